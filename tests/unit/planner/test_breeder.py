"""The breeder compared with the definition: children, margins, survivors, and its cycles."""

import numpy as np
import pytest

from pathgene.hdl.planner.breeder import Breeder
from pathgene.sim.model.planner import evolver_cycles
from tests.support.gateware.streams import collect, pulse, shared, simulate
from tests.support.planner.cases import LARGE, SMALL, USUAL
from tests.support.planner.plain import breed
from tests.support.planner.population import TINY, Words, corner, population, problem


class Bench:
    """A breeder with its neighbours, in Python; waypoints by slot, and members by rank."""

    def __init__(self, config, rng, words, *, pauses=(0,), busy=0.0):
        self.config, self.rng, self.words = config, rng, words
        self.dut = shared(Breeder, config, islands=2)
        self.memory = {}
        self.members = []
        self.free = []
        self.points, self.children = [], []
        self.cycle = self.begun = 0
        self.first_points = []
        self.parities = []
        self.planned = None
        self._pauses, self._busy = pauses, busy

    async def around(self, ctx):
        """Answer reads of members and waypoints, provide words and slots, and accept writes."""
        dut, rng = self.dut, self.rng
        earlier = None
        while True:
            stalls = rng.random(2) < self._busy
            word = self.words.draw()
            if not ctx.get(dut.words.valid):
                ctx.set(dut.words.payload, list(word))
                ctx.set(dut.words.valid, int(not stalls[0]))
            if self.free and not ctx.get(dut.slots.valid):
                ctx.set(dut.slots.payload, self.free[0])
                ctx.set(dut.slots.valid, int(not stalls[1]))
            await self._cycle(ctx, earlier)
            earlier = self._read

    async def _cycle(self, ctx, earlier):
        dut = self.dut
        (
            _,
            _,
            begins,
            planning,
            rank,
            read,
            write,
            gives,
            words,
            takes,
        ) = await ctx.tick().sample(
            dut.begin,
            dut.planning,
            dut.rank,
            dut.read,
            dut.write,
            dut.words.ready & dut.words.valid,
            dut.words.payload,
            dut.slots.ready & dut.slots.valid,
        )
        if begins:
            self.begun, self.planned = self.cycle, None
        elif not planning and self.planned is None:
            self.planned = self.cycle
        self.cycle += 1
        self._read = read.slot, read.index
        if self.members:
            slot, length = self.members[rank]
            ctx.set(dut.parent, {"slot": slot, "length": length})
        if earlier in self.memory:
            x, y, altitude, margin = self.memory[earlier]
            waypoint = {"x": x, "y": y, "altitude": altitude, "margin": margin}
            ctx.set(dut.waypoint, waypoint)
        if write.valid:
            waypoint = write.waypoint
            place = write.place.slot, write.place.index
            self.memory[place] = waypoint.x, waypoint.y, waypoint.altitude, waypoint.margin
        if gives:
            self.words.taken.append((words[0], words[1]))
            ctx.set(dut.words.valid, 0)
        if takes:
            self.free.pop(0)
            ctx.set(dut.slots.valid, 0)

    async def generation(self, ctx, record, ends, paths):
        """Breed a generation, and compare it with the definition."""
        config, dut = self.config, self.dut
        slots = self.rng.permutation(dut.slot_count).tolist()
        self.members = [(slots[rank], len(path)) for rank, path in enumerate(paths)]
        self.memory.clear()
        for (slot, _), path in zip(self.members, paths, strict=True):
            self.memory |= {(slot, index): tuple(each) for index, each in enumerate(path)}
        given = slots[config.population :][: config.children]
        self.free[:] = given
        self.points.clear()
        self.children.clear()
        self.first_points.clear()
        limits = record.x_limit, record.y_limit, record.altitude_limit
        for name, point in (("limits", limits), ("start", ends[0]), ("goal", ends[1])):
            ctx.set(dut.frame[name], corner(point))
        await pulse(ctx, dut.begin)
        for _ in range(40 * config.children * (config.max_waypoints + 8)):
            await ctx.tick()
            if sum(point[-1] for point in self.points) == config.children:
                break
        else:
            raise TimeoutError("A generation does not end")

        bred, survivors = breed(config, record, ends, paths, self.words)
        assert self.words.taken == []
        assert [ctx.get(rank) for rank in dut.survivors] == survivors
        parity = ctx.get(dut.parity)
        self.parities.append(parity)
        assert self.children == [(slot, parity) for slot in given]
        expected = [
            (*point[:3], int(number == len(child) + 1))
            for child in bred
            for number, point in enumerate([ends[0], *child, ends[1]])
        ]
        assert self.points == expected
        for slot, child in zip(given, bred, strict=True):
            written = [self.memory[slot, index] for index in range(len(child))]
            assert written == [tuple(each) for each in child]
        return bred

    def run(self, bench):
        def noted(point):
            if not self.points or self.points[-1][-1]:
                self.first_points.append(self.cycle - 1)
            return point.x, point.y, point.altitude, point.last

        self.points = _Mapped(noted)
        self.children = _Mapped(lambda child: (child.slot, child.parity))
        points = collect(self.dut.points, self.points, self._pauses)
        children = collect(self.dut.children, self.children, self._pauses)
        simulate(self.dut, bench, background=[self.around, points, children])


class _Mapped(list):
    """A list of the results of a function for each item appended."""

    def __init__(self, function):
        super().__init__()
        self._function = function

    def append(self, item):
        super().append(self._function(item))


def compare(config, generations, stalled):
    """Breed random populations for ``generations``; every generation is compared."""
    rng = np.random.default_rng(config.map_size + stalled)
    bench = Bench(
        config,
        rng,
        Words(rng),
        pauses=(0, 0, 3, 1, 0, 7) if stalled else (0,),
        busy=0.5 if stalled else 0.0,
    )

    async def generations_of(ctx):
        for _ in range(generations):
            record, ends = problem(config, rng)
            await bench.generation(ctx, record, ends, population(config, rng))

    bench.run(generations_of)
    assert bench.parities == [1 - number % 2 for number in range(generations)]


CONFIGS = {"tiny": (TINY, 12), "small": (SMALL, 12), "usual": (USUAL, 2), "large": (LARGE, 1)}


@pytest.mark.ci
@pytest.mark.parametrize("stalled", [False, True], ids=["steady", "stalled"])
@pytest.mark.parametrize("name", CONFIGS)
def test_matches_definition(name, stalled):
    config, generations = CONFIGS[name]
    compare(config, generations, stalled)


@pytest.mark.long
@pytest.mark.parametrize("stalled", [False, True], ids=["steady", "stalled"])
@pytest.mark.parametrize("name", CONFIGS)
def test_matches_definition_at_length(name, stalled):
    """There are some 10,000 children of each size."""
    config, _ = CONFIGS[name]
    compare(config, 10_000 // config.children, stalled)


def test_cycles():
    """Plans arrive at a constant rate; children follow their plans and each other."""
    rng = np.random.default_rng(5)
    bench = Bench(USUAL, rng, Words(rng))

    async def generations_of(ctx):
        for _ in range(2):
            record, ends = problem(USUAL, rng)
            bred = await bench.generation(ctx, record, ends, population(USUAL, rng))
            assert bench.planned - bench.begun == 8 * USUAL.children + 5
            at, points, firsts = 0, 0, []
            for number, child in enumerate(bred):
                at = evolver_cycles.begun(evolver_cycles.plan(bench.begun, number), at, points)
                points = len(child) + 2
                firsts.append(evolver_cycles.offered(at, 0))
            assert bench.first_points == firsts
            assert firsts[0] - bench.begun == 22

    bench.run(generations_of)
