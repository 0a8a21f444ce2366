"""Commands that a chip refuses and its replies, for the gateware and its model."""

import dataclasses

import numpy as np

from pathgene.hdl.protocol.codes import Command, LinkMode, Status
from pathgene.hdl.protocol.messages import (
    CODED_COLUMNS,
    check_paths_request,
    coded_map_request,
    map_request,
    start_request,
)
from pathgene.hdl.protocol.paths import pack_cells, pack_paths
from pathgene.hdl.protocol.planner import BLOCKS, SCALE_FRACTION, NoFlyShape
from pathgene.hdl.protocol.runs import RunOptions, guide_request, run_request
from tests.support.planner.cases import record


def refusals(config, order):
    """Return command, payload and status of each refusal by a chip with a population of 8.

    ``order`` is a valid ranking.
    """
    layout = start_request(config)
    good = {"seed": 0x0123456789ABCDEF, "x": 0, "y": 0, "altitude": 0, "avoid_ground": 0}
    start = layout.pack(**good)
    paths = [[1, 2], [1, 2]]
    return [
        (0, b"", Status.UNKNOWN_COMMAND),
        (200, b"abc", Status.UNKNOWN_COMMAND),
        (Command.INFO, b"", Status.UNKNOWN_COMMAND),
        (Command.STATUS, b"\0", Status.BAD_LENGTH),
        (Command.COUNTERS, b"\0", Status.BAD_LENGTH),
        (Command.CLEAR, b"abc", Status.BAD_LENGTH),
        (Command.START, b"", Status.BAD_LENGTH),
        (Command.START, start[:-1], Status.BAD_LENGTH),
        (Command.START, start + b"\0", Status.BAD_LENGTH),
        (Command.START, start * 9, Status.BAD_LENGTH),
        (Command.START, layout.pack(**good | {"x": config.map_size}), Status.BAD_VALUE),
        (Command.START, layout.pack(**good | {"y": config.map_size}), Status.BAD_VALUE),
        (
            Command.START,
            layout.pack(**good | {"altitude": config.blocked_altitude}),
            Status.BAD_VALUE,
        ),
        (Command.READ, b"\0", Status.BAD_LENGTH),
        (Command.READ, b"\0\1\0", Status.BAD_LENGTH),
        (Command.READ, b"\0\0", Status.BAD_VALUE),
        (Command.READ, b"\7\2", Status.BAD_VALUE),
        (Command.READ, b"\xff\xff", Status.BAD_VALUE),
        (Command.WRITE, b"", Status.BAD_LENGTH),
        (Command.WRITE, b"\0", Status.BAD_LENGTH),
        (Command.WRITE, b"\0\1", Status.BAD_LENGTH),
        (Command.WRITE, b"\0\1\0\0", Status.BAD_LENGTH),
        (Command.WRITE, b"\0\1\0", Status.BAD_VALUE),  # No last waypoint.
        (Command.WRITE, b"\0" + pack_paths(config, [[1]]), Status.BAD_VALUE),
        (
            Command.WRITE,
            b"\0" + pack_paths(config, [[1] * (config.max_waypoints + 1)]),
            Status.BAD_VALUE,
        ),
        (Command.WRITE, b"\7" + pack_paths(config, paths), Status.BAD_VALUE),
        (Command.WRITE, b"\x08" + pack_paths(config, paths[:1]), Status.BAD_VALUE),
        (Command.GENERATE, b"", Status.BAD_LENGTH),
        (Command.GENERATE, b"\3", Status.BAD_VALUE),
        (Command.GENERATE, b"\0\0", Status.BAD_LENGTH),
        (Command.GENERATE, bytes((LinkMode.RANK, *order[:-1])), Status.BAD_LENGTH),
        (Command.GENERATE, bytes((LinkMode.RANK, *order, 0, 1)), Status.BAD_LENGTH),
        (Command.GENERATE, bytes((LinkMode.RECIPE, *order[:-1], 8)), Status.BAD_VALUE),
        (Command.GENERATE, bytes((LinkMode.RECIPE, *order[:-1], order[0])), Status.BAD_VALUE),
    ]


def rectangle(config, x, y, width, height, cells):
    """Return the payload of a MAP."""
    header = map_request(config).pack(x=x, y=y, width=width, height=height)
    return header + pack_cells(config, cells)


def check(config, flags, path):
    """Return the payload of a CHECK."""
    return bytes((flags,)) + pack_paths(config, [path])


def check_paths(config, slot, count, flags, start=0x123, goal=0xABC):
    """Return the payload of a CHECK_PATHS."""
    return check_paths_request(config).pack(
        slot=slot, count=count, flags=flags, start=start, goal=goal
    )


def check_refusals(config):
    """Return the same for a checker with a map of 16 cells that has checked at most 5 paths."""
    single = map_request(config).pack(x=0, y=0, width=1, height=1)
    rectangles = [
        (0, 0, 0, 1, [1]), (0, 0, 1, 0, [1]), (15, 0, 2, 1, [1, 2]), (0, 15, 1, 2, [1, 2]),
        (0xFFFF, 0, 1, 1, [1]), (1, 0, 0xFFFF, 1, [1]), (0, 2, 1, 0xFFFF, [1]),
    ]  # fmt: skip
    wrong_lengths = [
        *((Command.MAP, payload) for payload in (b"", single[:-1], single)),
        *((Command.CHECK, payload) for payload in (b"", b"\0", b"\0" + bytes(3))),
        (Command.CHECK_PATHS, b""),
        (Command.CHECK_PATHS, check_paths(config, 0, 1, 0)[:-1]),
        (Command.CHECK_PATHS, check_paths(config, 0, 1, 0) + b"\0"),
        *((Command.RESULTS, payload) for payload in (b"\0", b"\0\1\0")),
    ]
    checks = [(4, [1, 2]), (0x81, [1, 2]), (0, [1]), (0, [1] * (config.max_waypoints + 3))]
    two_paths = check(config, 0, [1, 2]) + pack_paths(config, [[1, 2]])
    batches = [(0, 0, 0), (7, 2, 0), (255, 255, 0), (0, 1, 4)]
    beyond = start_request(config).pack(seed=0, x=16, y=0, altitude=0, avoid_ground=1)
    wrong_values = [
        *((Command.MAP, rectangle(config, *each)) for each in rectangles),
        *((Command.CHECK, check(config, *each)) for each in checks),
        (Command.CHECK, two_paths),
        *((Command.CHECK_PATHS, check_paths(config, *each)) for each in batches),
        *((Command.RESULTS, payload) for payload in (b"\0\0", b"\3\3", b"\xff\xff")),
        (Command.START, beyond),
    ]
    return [
        *((*each, Status.BAD_LENGTH) for each in wrong_lengths),
        *((*each, Status.BAD_VALUE) for each in wrong_values),
    ]


def run_refusals(config):
    """Return the same for a chip with the planner core that has a problem but no population."""
    problem = record(config, np.random.default_rng(1))
    layout = run_request(config)
    fields = layout.unpack(RunOptions(seeds=config.population).pack(config))
    shape = NoFlyShape(first_x=2, first_y=3, last_x=4, last_y=5, edges=())
    most_shift = max(config.coordinate_bits - 5, 0)

    def changed(**changes):
        return dataclasses.replace(problem, **changes).pack(config)

    packed, run, block = changed(), layout.pack(**fields), shape.pack(config)
    unknown = (
        Command.START, Command.WRITE, Command.GENERATE, Command.READ, Command.CHECK,
        Command.CHECK_PATHS, Command.RESULTS,
    )  # fmt: skip
    problems = [
        {"altitude_limit": config.blocked_altitude},
        {"x_scale": (1 << SCALE_FRACTION) + 1},
        {"y_scale": (1 << SCALE_FRACTION) + 1},
        {"block_shift": most_shift + 1},
        {"block_shift": 15},
    ]
    if config.map_size > BLOCKS:
        problems += [
            {"block_shift": 0, "x_limit": BLOCKS, "y_limit": 0},
            {"block_shift": 0, "y_limit": BLOCKS, "x_limit": 0},
        ]
    runs = [
        {"give_up_rank": config.population},
        {"seeds": config.population - 1},
        {"lifts": 5},
        {"share": 17},
        {"islands": 0},
        {"islands": 3},
        {"warm": 1, "islands": 1},
        {"warm": 1, "islands": 2},
        {"guided": 1},
        {"guided": config.max_waypoints + 1},
        {"guided": 255},
        {"guided": 2, "warm": 1, "islands": 0},
    ]
    coded = coded_map_request(config)
    hill = {"x": 1, "y": 2, "width": 1, "height": 2, "remainder_bits": 0}
    maps = [
        {"width": 0},
        {"height": 0},
        {"x": config.map_size},
        {"y": config.map_size - 1},
        {"remainder_bits": config.altitude_bits},
        {"remainder_bits": 255},
        {"x": 0, "width": config.map_size + 1},
    ]
    if config.map_size > CODED_COLUMNS:
        maps.append({"x": 0, "width": CODED_COLUMNS + 1})
    guide = guide_request(config)
    waypoint = guide.pack(index=0, x=1, y=2, altitude=3)
    unknown = 0, max(Command) + 1, 200, *unknown
    return [
        *((code, bytes(5), Status.UNKNOWN_COMMAND) for code in unknown),
        *(
            (code, payload, Status.BAD_LENGTH)
            for code, whole in (
                (Command.PROBLEM, packed), (Command.RUN, run), (Command.BLOCK, block),
                (Command.GUIDE, waypoint),
            )
            for payload in (b"", whole[:-1], whole + b"\0")
        ),
        (Command.STOP, b"\0", Status.BAD_LENGTH),
        (Command.BEST, b"\0", Status.BAD_LENGTH),
        (Command.MAP, b"", Status.BAD_LENGTH),
        (Command.MAP, map_request(config).pack(x=0, y=0, width=0, height=1), Status.BAD_VALUE),
        *((Command.PROBLEM, changed(**changes), Status.BAD_VALUE) for changes in problems),
        *((Command.RUN, layout.pack(**fields | changes), Status.BAD_VALUE) for changes in runs),
        *(
            (Command.BLOCK, dataclasses.replace(shape, **last).pack(config), Status.BAD_VALUE)
            for last in ({"last_x": 1}, {"last_y": 2})
        ),
        *((Command.CODED_MAP, data, Status.BAD_LENGTH) for data in (b"", coded.pack(**hill))),
        *(
            (Command.CODED_MAP, coded.pack(**hill | changes) + b"\0", Status.BAD_VALUE)
            for changes in maps
        ),
        *(
            (Command.GUIDE, guide.pack(index=index, x=0, y=0, altitude=0), Status.BAD_VALUE)
            for index in (config.max_waypoints, 255)
        ),
    ]  # fmt: skip
