"""The builder of children: its cycles and its waits; more children in ``test_breeder``."""

import numpy as np
import pytest

from pathgene.hdl.planner.child_builder import ChildBuilder
from tests.support.gateware.streams import shared, simulate
from tests.support.planner.cases import SMALL
from tests.support.planner.plain import cross, mutate
from tests.support.planner.population import Words, corner, plan_of, population, problem


SIZES = {
    "slot_count": 12,
    "max_waypoints": SMALL.max_waypoints,
    "coordinate_bits": SMALL.coordinate_bits,
    "altitude_bits": SMALL.altitude_bits,
    "box_cells": SMALL.box_cells,
    "box_steps": SMALL.box_steps,
}
#: Cycles from a plan, and from a child's first cycle, to the start point among ``points``.
LATENCY = 9
#: Points on offer or in flight.
POINTS = 16


class Bench:
    """A builder with a memory; it notes the cycles of inputs and outputs."""

    def __init__(self, children):
        self.dut = shared(ChildBuilder, **SIZES)
        self.rng = rng = np.random.default_rng(children)
        self.record, self.ends = problem(SMALL, rng)
        self.paths = population(SMALL, rng)
        source = Words(rng)
        self.plans, self.bred = [], []
        for _ in range(children):
            head, tail = (int(slot) for slot in rng.integers(len(self.paths), size=2))
            word = source.draw()[1]
            parents = (head, len(self.paths[head])), (tail, len(self.paths[tail]))
            self.plans.append(plan_of(SIZES, *parents, word))
            child = cross(self.paths[head], self.paths[tail], word)
            self.bred.append(mutate(SMALL, self.record, self.ends, child, word))
        self.cycle = 0
        self.taken, self.children, self.points, self.written = [], [], [], []
        self.ready = {"plans": 1, "slots": 1, "children": 1, "points": 1}

    def run(self, cycles, control=lambda bench: None):
        """Simulate; ``control`` may change each ``ready`` before each cycle."""
        dut = self.dut

        async def bench(ctx):
            limits = self.record.x_limit, self.record.y_limit, self.record.altitude_limit
            for name, point in zip(("limits", "start", "goal"), (limits, *self.ends), strict=True):
                ctx.set(dut.frame[name], corner(point))
            earlier = None
            for self.cycle in range(cycles):
                control(self)
                left = self.plans[len(self.taken) :]
                ctx.set(dut.plans.valid, self.ready["plans"] and bool(left))
                if left:
                    ctx.set(dut.plans.payload, left[0])
                ctx.set(dut.slots.valid, self.ready["slots"])
                ctx.set(dut.slots.payload, 8 + len(self.taken) % 4)
                ctx.set(dut.children.ready, self.ready["children"])
                ctx.set(dut.points.ready, self.ready["points"])
                takes = [
                    ctx.get(each.valid & each.ready)
                    for each in (dut.plans, dut.slots, dut.children)
                ]
                assert len(set(takes)) == 1
                if takes[0]:
                    self.children.append(ctx.get(dut.children.payload))
                    self.taken.append(self.cycle)
                if ctx.get(dut.points.valid & dut.points.ready):
                    self.points.append((self.cycle, ctx.get(dut.points.payload)))
                if ctx.get(dut.write.valid):
                    self.written.append((self.cycle, ctx.get(dut.write)))
                read = ctx.get(dut.read)
                await ctx.tick()
                if earlier is not None and earlier[0] < len(self.paths):
                    path = self.paths[earlier[0]]
                    if earlier[1] < len(path):
                        held = path[earlier[1]]
                        ctx.set(dut.waypoint, {**corner(held[:3]), "margin": held.margin})
                earlier = read.slot, read.index

        simulate(dut, bench)

    def check(self):
        """Compare all children with the definition's."""
        assert self.children == [8 + i % 4 for i in range(len(self.bred))]
        points = [(p.x, p.y, p.altitude, p.last) for _, p in self.points]
        start, goal = ((*end, last) for last, end in enumerate(self.ends))
        assert points == [
            point for child in self.bred for point in (start, *((*w[:3], 0) for w in child), goal)
        ]
        written = [
            (w.place.slot, w.place.index, w.waypoint.x, w.waypoint.y, w.waypoint.altitude,
             w.waypoint.margin)
            for _, w in self.written
        ]  # fmt: skip
        assert written == [
            (8 + i % 4, index, *each)
            for i, child in enumerate(self.bred)
            for index, each in enumerate(child)
        ]


def test_a_point_a_cycle():
    """Children follow each other without gaps; a waypoint is written before it is offered."""
    bench = Bench(300)
    bench.run(300 * (SMALL.max_waypoints + 2) + 20)
    bench.check()
    lengths = [len(child) + 2 for child in bench.bred]
    assert set(lengths) == set(range(4, SMALL.max_waypoints + 3))
    assert np.diff(bench.taken).tolist() == lengths[:-1]
    first = bench.taken[0] + LATENCY
    assert [cycle for cycle, _ in bench.points] == list(range(first, first + sum(lengths)))
    first_cycles = first + np.cumsum([0, *lengths[:-1]])
    assert [cycle for cycle, _ in bench.written] == [
        start + number - 1
        for start, length in zip(first_cycles, lengths, strict=True)
        for number in range(1, length - 1)
    ]


def test_waits_for_points_to_be_taken():
    bench = Bench(40)

    def control(bench):
        bench.ready["points"] = int(bench.cycle > 100)

    bench.run(100 + 40 * (SMALL.max_waypoints + 2) + 30, control)
    bench.check()
    lengths = [len(child) + 2 for child in bench.bred]
    stuck = sum(cycle <= 100 for cycle in bench.taken)
    assert sum(lengths[: stuck - 1]) <= POINTS < sum(lengths[:stuck])


@pytest.mark.parametrize("name", ["plans", "slots", "children"])
def test_waits_for_each(name):
    bench = Bench(40)

    def control(bench):
        bench.ready[name] = int(bench.rng.random() < 0.1)

    bench.run(40 * 40, control)
    bench.check()


def test_everything_stalls():
    bench = Bench(60)

    def control(bench):
        bench.ready = {name: int(bench.rng.random() < 0.5) for name in bench.ready}

    bench.run(60 * 40, control)
    bench.check()


@pytest.mark.parametrize(("slots", "bits"), [(15, 4), (16, 4), (17, 5)])
def test_width_of_a_slot(slots, bits):
    dut = shared(ChildBuilder, **SIZES | {"slot_count": slots})
    assert len(dut.children.payload) == bits
    assert dut.plan_layout["tail_slot"].width == bits
