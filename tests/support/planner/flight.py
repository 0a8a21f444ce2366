"""A planner on a chip and its model, compared on the same maps, problems and runs."""

import numpy as np

from pathgene.hdl.layouts import struct
from pathgene.hdl.planner.core import run_status_layout
from pathgene.hdl.planner.layouts import problem_layout, shape_layout
from pathgene.hdl.protocol.codes import UNITS
from pathgene.hdl.protocol.planner import VALUE_BITS, NoFlyShape, PathClass
from pathgene.hdl.protocol.runs import (
    ISLANDS,
    RETURNED,
    RunOptions,
    guide_request,
    pack_best,
    run_request,
)
from pathgene.sim.model.planner.run import NEVER, plan
from pathgene.sim.model.run_commands import BlockMarks
from tests.support.planner import cases as planner_cases
from tests.support.planner.plain import drawn


def problem_payload(config, record):
    """Return the payload of a problem."""
    return problem_layout(config).const(vars(record))


def shape_payload(config, shape):
    """Return the payload of a shape."""
    layout = shape_layout(config.coordinate_bits)
    values = {name: getattr(shape, name) for name, _ in layout if hasattr(shape, name)}
    for i, edge in enumerate(shape.edges):
        values |= {
            f"{name}_{i}": part for name, part in zip(("at", "east", "north"), edge, strict=True)
        }
    return layout.const(values)


def run_payload(config, options):
    """Return the payload of a run."""
    request = run_request(config)
    return struct(request).const(request.unpack(options.pack(config)))


def guide_payload(config, index, waypoint):
    """Return the payload of a waypoint of the guide."""
    values = {"index": index, **dict(zip(("x", "y", "altitude"), waypoint, strict=True))}
    return struct(guide_request(config)).const(values)


def status_fields(bits):
    """Return the fields of its status."""
    return {
        name: bits >> field.offset & (1 << field.width) - 1 for name, field in run_status_layout()
    }


class Flight:
    """A planner and its model.

    Parameters
    ----------
    rows : int
        Rows of its memo.
    seed : int
        It determines all maps, problems and options.
    chip : object
        The planner, with the methods of ``VerilatedPlanner`` in ``tests/cosim``.
    """

    def __init__(self, config, rows, seed, chip):
        self.config, self.rows, self.chip = config, rows, chip
        self.rng = np.random.default_rng(seed)
        self.marks = BlockMarks()
        self.ground = self.record = self.outcome = None
        self.guide = np.zeros((config.max_waypoints, 3), dtype=np.int64)
        self.kinds = set()

    def choose(self, *values):
        return values[int(self.rng.integers(len(values)))]

    def upload(self):
        """Upload a new map."""
        blocked = self.choose(0, 0.001, 0.02)
        self.ground = planner_cases.ground(self.config, self.rng, blocked=blocked)
        y, x = np.indices(self.ground.shape)
        self._write(x.ravel(), y.ravel())

    def change(self):
        """Write some corners, or draw a shape."""
        config, size = self.config, self.config.map_size
        if self.rng.random() < 0.5:
            x, y = self.rng.integers(size, size=(2, int(self.rng.integers(30))))
            heights = self.rng.integers(config.blocked_altitude + 1, size=len(x))
            self.ground[y, x] = heights
            self._write(x, y)
        else:
            # In the chip's form, with all edges.
            shape = NoFlyShape.unpack(config, planner_cases.shape(config, self.rng).pack(config))
            corners = np.array(drawn(shape), dtype=int).reshape(-1, 2)
            self.ground[corners[:, 1], corners[:, 0]] = config.blocked_altitude
            assert self.chip.draw(shape) == shape.drawing_cycles - 1
            self.marks.write(corners[:, 0], corners[:, 1])

    def _write(self, x, y):
        self.chip.write(self.ground, x, y)
        self.marks.write(x, y)

    def pose(self, **changes):
        """Pose a problem; some have an entry and an exit."""
        self.record = planner_cases.record(self.config, self.rng, **changes)
        if self.rng.random() < 0.6:
            self.record = planner_cases.headed(self.config, self.rng, self.record)
        self.chip.pose(self.record)
        self.marks.shift = self.record.block_shift
        flags, status = self.chip.status()
        assert flags == [1, self.outcome is not None, 0]
        assert status["running"] == 0
        assert status["key"] >> VALUE_BITS == PathClass.VOID

    def lead(self):
        """Write some waypoints of the guide, a few of them beyond the limits."""
        config, rng = self.config, self.rng
        for _ in range(int(rng.integers(1, 2 * config.max_waypoints))):
            index = int(rng.integers(config.max_waypoints))
            corner = rng.integers(config.map_size, size=2).tolist()
            self.guide[index] = *corner, int(rng.integers(config.blocked_altitude + 1))
            self.chip.lead(index, self.guide[index].tolist())

    def options(self, generations):
        rng = self.rng
        warm = self.outcome is not None and rng.random() < 0.4
        slopes = rng.integers(16, size=int(rng.integers(1 - warm, ISLANDS + 1 - warm))).tolist()
        cycles = self.choose(0, 30_000, 100_000, 10**9)
        guided = 0
        if slopes and rng.random() < 0.3:
            guided = int(rng.integers(self.config.MIN_WAYPOINTS, self.config.max_waypoints + 1))
        return RunOptions(
            seed=int(rng.integers(1 << 63)),
            cycles=cycles,
            generations=int(rng.integers(generations)),
            # Some problems have no feasible path.
            until_feasible=cycles < 10**9 and rng.random() < 0.5,
            give_up_rank=int(rng.integers(self.config.population)),
            slopes=tuple(slopes),
            seeds=self.config.population + int(rng.integers(40)),
            lifts=int(rng.integers(5)),
            share=int(rng.integers(17)),
            paths=int(rng.integers(1, RETURNED + 1)),
            warm=warm,
            guided=guided,
            memo=self.rows,
        )

    def run(self, options, stop=0):
        """Run both, stop them in the given cycle (0: never), and compare everything."""
        before = self.outcome.population if options.warm else None
        marked = self.marks.scan()
        self.outcome = out = plan(
            self.config,
            self.ground,
            self.record,
            options,
            before,
            guide=self.guide,
            marked=marked,
            stop=stop or NEVER,
        )
        done = self.chip.run(options, gap=int(self.rng.integers(3)), stop=stop)
        assert done == (out.cycles, out.generations), options
        self.compare(options)
        islands = len(options.slopes) + options.warm
        waited = out.generations > options.generations
        self.kinds.add((islands, options.warm, self.record.has_entry, self.record.has_exit, waited))

    def compare(self, note):
        out = self.outcome
        flags, status = self.chip.status()
        assert flags == [1, 1, 1]
        assert status == {
            "running": 0,
            "generation": out.generations,
            "cycles": out.cycles,
            "key": out.keys[0],
            **{name: getattr(out, name) for name in UNITS},
        }, note
        bits = self.config.coordinate_bits
        packed = [[x | y << bits | z << 2 * bits for x, y, z in path] for path in out.paths]
        stall = self.choose(0, 0, 3)
        assert self.chip.best(stall) == pack_best(self.config, packed, out.keys), note
