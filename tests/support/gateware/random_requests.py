"""Random requests that a chip executes, for every command that it knows."""

from pathgene.hdl.protocol.codes import CheckFlag, Command, LinkMode
from pathgene.hdl.protocol.messages import (
    check_paths_request,
    check_request,
    coded_map_request,
    map_request,
    read_request,
    results_request,
    start_request,
    write_request,
)
from pathgene.hdl.protocol.paths import pack_cells, pack_paths
from pathgene.hdl.protocol.runs import RunOptions, guide_request, run_request
from tests.support.gateware.chips import random_path
from tests.support.gateware.coded_cells import encode
from tests.support.planner.cases import any_record, headed, record, shape


#: Commands of every chip, and how often each is drawn.
_COMMON_WEIGHTS = {
    Command.STATUS: 6,
    Command.COUNTERS: 6,
    Command.CLEAR: 5,
    Command.INFO: 3,
    Command.OPEN: 3,
}
#: Commands of the paper core, which precede these.
_WEIGHTS = {
    Command.GENERATE: 30,
    Command.WRITE: 25,
    Command.READ: 15,
    Command.START: 7,
    **_COMMON_WEIGHTS,
}
#: Additional commands of a chip with a checker.
_CHECKER_WEIGHTS = {
    Command.MAP: 8,
    Command.CHECK: 10,
    Command.CHECK_PATHS: 10,
    Command.RESULTS: 4,
}
#: All commands of a chip with the planner core.
_RUN_WEIGHTS = {
    Command.MAP: 8,
    Command.PROBLEM: 8,
    Command.RUN: 12,
    Command.STOP: 4,
    Command.BEST: 12,
    Command.BLOCK: 8,
    Command.GUIDE: 8,
    Command.CODED_MAP: 8,
    **_COMMON_WEIGHTS,
}
#: Values that a RUN may not have, whatever the chip.
_WRONG_RUNS = (
    {"islands": 3},
    {"islands": 0, "warm": 0},
    {"lifts": 5},
    {"share": 17},
    {"seeds": 1},
    {"paths": 0},
    {"paths": 9},
    {"guided": 1},
    {"guided": 255},
    {"guided": 2, "islands": 0, "warm": 1},
)


class RandomRequests:
    """Source of commands and payloads.

    One in ten RUNs has a value out of range; a warm RUN and a RESULTS are refused if the chip has
    no population or no such results. A chip executes everything else, including the requests of
    :mod:`tests.support.planner.cases` with arbitrary values.

    Parameters
    ----------
    draws : numpy.random.Generator
        Source of problems and shapes.
    """

    def __init__(self, config, rng, draws):
        self.config = config
        self._rng = rng
        self._draws = draws
        self._weights = dict(_RUN_WEIGHTS if config.planner_core else _WEIGHTS)
        if config.checks_paths:
            self._weights |= _CHECKER_WEIGHTS

    def command(self):
        """Return a command; common ones are more frequent."""
        return self._rng.choices(list(self._weights), self._weights.values())[0]

    def payload(self, code):
        """Return a payload of the command ``code``."""
        config, rng = self.config, self._rng
        if code == Command.START:
            return start_request(config).pack(
                seed=rng.getrandbits(64),
                x=rng.randrange(config.map_size),
                y=rng.randrange(config.map_size),
                altitude=rng.randrange(config.blocked_altitude),
                avoid_ground=config.checks_paths and rng.random() < 0.5,
            )
        if code in _CHECKER_WEIGHTS:
            return self._checker_payload(code)
        if self.config.planner_core:
            return self._run_payload(code)
        slot = rng.randrange(config.population)
        count = rng.randint(1, config.population - slot)
        if code == Command.WRITE:
            return self.paths(slot, min(count, 3))
        if code == Command.READ:
            return read_request(config).pack(slot=slot, count=count)
        if code == Command.GENERATE:
            mode = rng.choice(list(LinkMode))
            order = rng.sample(range(config.population), config.population)
            return bytes((mode, *(() if mode is LinkMode.POPULATION else order)))
        return b""

    def paths(self, slot, count):
        """Return a WRITE of ``count`` paths, starting at ``slot``."""
        paths = [random_path(self.config, self._rng) for _ in range(count)]
        return write_request(self.config).pack(slot=slot) + pack_paths(self.config, paths)

    def _checker_payload(self, code):
        config, rng = self.config, self._rng
        flags = rng.choices((0, CheckFlag.COUNT, CheckFlag.BRIEF, 3), (4, 4, 1, 1))[0]
        if code == Command.MAP:
            x, y = (rng.randrange(config.map_size) for _ in "xy")
            width, height = (rng.randint(1, min(6, config.map_size - at)) for at in (x, y))
            top = rng.choice((config.blocked_altitude // 2, config.blocked_altitude))
            cells = [rng.randint(0, top) for _ in range(width * height)]
            header = map_request(config).pack(x=x, y=y, width=width, height=height)
            return header + pack_cells(config, cells)
        if code == Command.CHECK:
            path = random_path(config, rng, rng.randint(2, config.max_waypoints + 2))
            return check_request(config).pack(flags=flags) + pack_paths(config, [path])
        slot = rng.randrange(config.population)
        count = rng.randint(1, config.population - slot)
        if code == Command.RESULTS:
            return results_request(config).pack(path=slot // 2, count=min(count, 2))
        start, goal = random_path(config, rng, 2)
        return check_paths_request(config).pack(
            slot=slot, count=count, flags=flags, start=start, goal=goal
        )

    def _run_payload(self, code):
        config, rng, draws = self.config, self._rng, self._draws
        if code == Command.PROBLEM:
            usual = record(config, draws) if rng.random() < 0.7 else any_record(config, draws)
            return headed(config, draws, usual).pack(config)
        if code == Command.BLOCK:
            return shape(config, draws).pack(config)
        if code == Command.CODED_MAP:
            x, y = (rng.randrange(config.map_size) for _ in "xy")
            width, height = (rng.randint(1, min(9, config.map_size - at)) for at in (x, y))
            altitudes = rng.choices(range(config.blocked_altitude + 1), k=width * height)
            k = rng.randrange(config.altitude_bits)
            header = coded_map_request(config).pack(
                x=x, y=y, width=width, height=height, remainder_bits=k + rng.choice((0, 0, 0, 1))
            )
            return header + encode(altitudes, width, config.altitude_bits, k)[0]
        if code == Command.GUIDE:
            layout = guide_request(config)
            values = {name: rng.getrandbits(width) for name, width in layout.fields}
            return layout.pack(**values | {"index": rng.randrange(config.max_waypoints + 1)})
        if code == Command.RUN:
            warm = rng.random() < 0.5
            slopes = tuple(rng.choices(range(16), k=rng.randint(1 - warm, 2 - warm)))
            lengths = range(config.MIN_WAYPOINTS, config.max_waypoints + 1)
            options = RunOptions(
                seed=rng.getrandbits(64),
                cycles=rng.randrange(1 << rng.randrange(8, 18)),
                generations=rng.randrange(6),
                until_feasible=rng.random() < 0.3,
                give_up_rank=rng.randrange(config.population),
                slopes=slopes,
                guided=rng.choice(lengths) if slopes and rng.random() < 0.3 else 0,
                seeds=config.population + rng.randrange(config.population),
                lifts=rng.randrange(5),
                share=rng.randrange(17),
                paths=rng.randrange(1, 9),
                warm=warm,
            )
            layout = run_request(config)
            fields = layout.unpack(options.pack(config))
            if rng.random() < 0.1:
                fields |= rng.choice(_WRONG_RUNS)
            return layout.pack(**fields)
        return b""
