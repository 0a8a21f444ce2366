"""An evolver with its neighbouring units, and the definition's populations to compare with."""

import itertools
from collections import deque
from dataclasses import dataclass, field

import numpy as np
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from pathgene.hdl.ga_core.random_source import RandomSource
from pathgene.hdl.planner.evolver import Evolver
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass
from pathgene.sim.model import random_source
from pathgene.sim.model.planner.evaluation import NO_LIMIT
from tests.support.gateware.streams import pulse, shared, simulate
from tests.support.planner import cases as planner_cases
from tests.support.planner.plain import Evaluator, Waypoint, breed
from tests.support.planner.population import corner, waypoint


_GIVEN_UP = PathClass.GIVEN_UP << VALUE_BITS
#: Maximum number of seeds that have a slot but no key.
_SEEDS = 18


class WithSource(wiring.Component):
    """An evolver that can be reset, and the chip's random source."""

    def __init__(self, config, islands):
        self.evolver = Evolver(config, islands)
        super().__init__({"load": In(1), "seed": In(64), "reset": In(1)})

    def elaborate(self, platform):
        m = Module()
        evolver = self.evolver
        m.submodules.evolver = ResetInserter(self.reset)(evolver)
        m.submodules.source = source = RandomSource()
        m.d.comb += [
            source.load.eq(self.load),
            source.seed.eq(self.seed),
            evolver.words.payload.eq(source.words),
            evolver.words.valid.eq(source.ready),
            source.step.eq(evolver.words.valid & evolver.words.ready),
        ]
        return m


@dataclass(eq=False)
class Member:
    """A path with its key, and its slot once it has one."""

    path: list
    key: int
    slot: int | None = None


@dataclass(eq=False)
class Child:
    """A child, as planned and as evaluated.

    ``margins`` are None if it is not walked; ``others`` are the paths whose slots it must not have.
    """

    points: list
    head: tuple
    member: Member
    margins: list | None
    others: list
    taken: list = field(default_factory=list)


@dataclass
class Cycle:
    """Events of a cycle, by the names of the evolver's members, and the key taken, if any."""

    begin: bool
    finish: bool
    merge: bool
    store: bool
    fills: bool
    ready: bool
    pending: bool
    accepts: bool
    points: bool
    children: bool
    key: int | None


class Bench:
    """Drives an evolver and compares all its outputs with the definition.

    Parameters
    ----------
    pace : str
        Pace of the points: "fast", "scorer" for one every two cycles, "stalled" for random pauses
        of everything.
    any_key : bool
        Draw keys, many of them equal, and margins; otherwise the definition evaluates.
    latency : int
        Minimum cycles from a child's goal to its key.
    """

    def __init__(self, config, seed, *, islands=2, pace="fast", any_key=True, latency=0):
        self.config, self.seed, self.pace, self.latency = config, seed, pace, latency
        self.any_key = any_key
        self.rng = rng = np.random.default_rng(seed)
        self.give_up_rank = config.population // 4
        self.record = planner_cases.record(config, rng)
        ground = planner_cases.ground(config, rng)
        self.evaluator = Evaluator(config, self.record, ground, 0)
        self.ends = self.evaluator.ends
        self.top = shared(WithSource, config, islands)
        self.dut = self.top.evolver
        self.cycles = []
        self.keys = []
        self.forget()

    def forget(self):
        """Forget all populations and all members in flight."""
        self.source = random_source.RandomSource(self.seed)
        self.islands, self.pending, self.survivors = {}, [], []
        self.coming, self.built, self.due = deque(), deque(), deque()
        self.decisions, self.margins = deque(), deque()
        # Points of each child, and for each pass the keys of the members that stay.
        self.lengths, self.stays = [], []

    # The definition.

    def evaluate(self, path, limit, *, first):
        """Return the key of a path, and its margins, None if it is not walked."""
        if self.any_key:
            value = int(self.rng.choice([0, 1, 2, (1 << VALUE_BITS) - 1]))
            key = int(self.rng.choice(list(PathClass))) << VALUE_BITS | value
            top = self.config.blocked_altitude
            if first and self.rng.random() < 0.5:
                return key, None
            return key, self.rng.integers(-top, top + 1, size=len(path)).tolist()
        points = [self.ends[0], *(each[:3] for each in path), self.ends[1]]
        margins = [None] * len(points)
        key = self.evaluator.evaluate(points, margins, limit, first=first)
        return key, None if None in margins[1:-1] else margins[1:-1]

    def evaluated(self, path, limit=NO_LIMIT, *, first=False):
        """Return a path with its key and new margins, and these margins."""
        key, margins = self.evaluate(path, limit, first=first)
        self.keys.append(key)
        if margins is not None:
            both = zip(path, margins, strict=True)
            path = [each._replace(margin=margin) for each, margin in both]
        return Member(path, key), margins

    def breed(self, island):
        """Breed a generation, and collect the pending one."""
        population = self.bred_from = self.islands[island]
        paths = [member.path for member in population]
        children, survivors = breed(self.config, self.record, self.ends, paths, self.source)
        first = population[0].key < _GIVEN_UP
        key = population[self.give_up_rank].key
        limited = key < _GIVEN_UP
        bred = []
        others = [*itertools.chain(*self.islands.values()), *self.pending]
        for child in children:
            member, margins = self.evaluated(child, key if limited else NO_LIMIT, first=first)
            points = [self.ends[0], *(each[:3] for each in child), self.ends[1]]
            limit = key % (1 << VALUE_BITS)
            self.coming.append(
                Child(points, (first, limited, limit), member, margins, [*others, *bred])
            )
            bred.append(member)
            self.lengths.append(len(points))
        self.survivors = survivors
        self.collect(island)
        self.pending = bred

    def collect(self, island):
        """Collect the pending generation, if any."""
        if self.pending:
            population, elites = self.islands[island], self.config.elites
            ranks = [*range(elites), *sorted(self.survivors)]
            kept = [population[rank] for rank in ranks]
            self.stays.append([member.key for member in kept])
            self.islands[island] = _sorted(kept + self.pending)
            self.pending = []

    # The evolver.

    async def start(self, ctx):
        """Load the seed and set the constant inputs."""
        dut, record = self.dut, self.record
        ctx.set(self.top.seed, self.seed)
        ctx.set(self.top.load, 1)
        ctx.set(dut.clear, 1)
        limits = record.x_limit, record.y_limit, record.altitude_limit
        ends = self.ends
        for name, point in (("limits", limits), ("start", ends[0]), ("goal", ends[1])):
            ctx.set(dut.frame[name], corner(point))
        ctx.set(dut.give_up_rank, self.give_up_rank)
        await ctx.tick()
        ctx.set(self.top.load, 0)
        ctx.set(dut.clear, 0)
        await ctx.tick().repeat(40)

    async def reset(self, ctx):
        """Reset the evolver, and start over."""
        await pulse(ctx, self.top.reset)
        self.forget()
        self.cycles.clear()

    async def wait(self, ctx, condition):
        """Wait until a condition holds."""
        for _ in range(20_000):
            if condition():
                return
            await ctx.tick()
        raise TimeoutError(f"{condition} does not hold")

    async def ready(self, ctx):
        await self.wait(ctx, lambda: ctx.get(self.dut.ready))

    async def pulse(self, ctx, signal, island):
        """Give a command and wait until the next one is allowed."""
        ctx.set(self.dut.island, island)
        await pulse(ctx, signal)
        await self.ready(ctx)

    async def begin(self, ctx, island):
        self.breed(island)
        await self.pulse(ctx, self.dut.begin, island)
        assert ctx.get(self.dut.pending)

    async def finish(self, ctx, island):
        self.collect(island)
        await self.pulse(ctx, self.dut.finish, island)
        assert not ctx.get(self.dut.pending)

    async def merge(self, ctx):
        each = self.config.population // 2
        best = self.islands[0][:each] + self.islands[1][:each]
        self.stays.append([member.key for member in best])
        self.islands = {0: _sorted(best)}
        await self.pulse(ctx, self.dut.merge, 0)

    async def fill(self, ctx, island, count):
        """Make a first population of ``count`` random paths."""
        config, dut = self.config, self.dut
        ctx.set(dut.fills, 1)
        ctx.set(dut.island, island)
        self.islands.pop(island, None)
        members = []
        most = max(2 * config.children, _SEEDS)
        for number in range(count):
            await self.wait(ctx, lambda: len(self.due) < most and ctx.get(dut.slots.valid))
            ctx.set(dut.slots.ready, 1)
            _, _, slot = await ctx.tick().sample(dut.slots.payload)
            ctx.set(dut.slots.ready, 0)
            assert slot not in {each.slot for each in self.inside(members)}
            # Some paths occur twice, so that keys are equal.
            path = members[-1].path if members and number % 3 == 0 else self.path()
            members.append(await self.place(ctx, slot, path))
        self.islands[island] = await self.store(ctx, members)

    def inside(self, members):
        """Return the members with slots in use: of all islands, and of an island's first paths."""
        known = members[: len(members) - len(self.due)]
        best = _sorted(known)[: self.config.population]
        return [*itertools.chain(*self.islands.values()), *best, *members[len(known) :]]

    def path(self):
        """Return a random path on the map."""
        config = self.config
        path = []
        for _ in range(int(self.rng.integers(2, config.max_waypoints + 1))):
            x, y, z, margin = waypoint(config, self.rng)
            most = config.map_size - 2
            path.append(
                Waypoint(min(x, most), min(y, most), min(z, 2**config.altitude_bits - 2), margin)
            )
        return path

    async def place(self, ctx, slot, path):
        """Write a first path, which has no margins, and have it evaluated; return it."""
        dut = self.dut
        for index, each in enumerate(path):
            place = {"slot": slot, "index": index}
            ctx.set(dut.write, {"valid": 1, "place": place, "waypoint": corner(each[:3])})
            await ctx.tick()
        ctx.set(dut.write.valid, 0)
        member, margins = self.evaluated(path)
        member.slot = slot
        self.give(member, margins)
        return member

    def give(self, member, margins):
        """Give the decision on a path, its margins and its key."""
        self.decisions.append((member.slot, margins is not None))
        self.margins += [(member.slot, *each) for each in enumerate(margins or ())]
        self.due.append((len(self.cycles) + self.pause(self.latency), member))

    async def store(self, ctx, members):
        """Complete a first population; return it."""
        await self.wait(ctx, lambda: not self.due)
        await pulse(ctx, self.dut.store)
        await self.ready(ctx)
        ctx.set(self.dut.fills, 0)
        return _sorted(members)[: self.config.population]

    async def revise(self, ctx, island):
        """Rewrite each member in its slot, shortened or moved, as a first population."""
        dut, config = self.dut, self.config
        ctx.set(dut.fills, 1)
        ctx.set(dut.island, island)
        members = []
        for rank, member in enumerate(self.islands[island]):
            await self.read(ctx, rank, member)
            dropped = int(self.rng.integers(len(member.path) - 1)) if rank % 2 else 0
            top = config.blocked_altitude - 1
            path = [each._replace(z=(each.z + rank) % top) for each in member.path[dropped:]]
            members.append(await self.place(ctx, member.slot, path))
        self.islands[island] = await self.store(ctx, members)

    async def read(self, ctx, rank, expected):
        """Compare a member with the definition's member."""
        dut = self.dut
        ctx.set(dut.rank, rank)
        await ctx.tick()
        member = ctx.get(dut.member)
        held = member.key, member.length, member.slot
        assert held == (expected.key, len(expected.path), expected.slot), rank
        if not ctx.get(dut.pending):
            for index, each in enumerate(expected.path):
                ctx.set(dut.read, {"slot": member.slot, "index": index})
                await ctx.tick().repeat(2)
                held = ctx.get(dut.waypoint)
                assert Waypoint(held.x, held.y, held.altitude, held.margin) == each, (rank, index)

    async def compare(self, ctx, island):
        """Compare the population of an island with the definition's population."""
        ctx.set(self.dut.island, island)
        for rank, expected in enumerate(self.islands[island]):
            await self.read(ctx, rank, expected)
        members = [*itertools.chain(*self.islands.values()), *self.pending]
        slots = [each.slot for each in members if each.slot is not None]
        assert len(set(slots)) == len(slots)

    # Around it.

    def pause(self, least):
        """Return a time between the minimum and twice the minimum."""
        return int(self.rng.integers(2 * least + 30)) if self.pace == "stalled" else least

    async def around(self, ctx):
        """Take children and points, answer like an evaluator, and note the events of each cycle."""
        dut, rng = self.dut, self.rng
        while True:
            stalls = rng.random(5) < (0.4 if self.pace == "stalled" else 0)
            now = len(self.cycles)
            ctx.set(dut.children.ready, not stalls[0])
            is_turn = self.pace != "scorer" or now % 2 == 0
            ctx.set(dut.points.ready, bool(self.built) and is_turn and not stalls[1])
            # A key follows all margins and decisions.
            known = not self.margins and not self.decisions
            margin, decision = {"valid": 0}, {"valid": 0}
            if self.margins and not stalls[2]:
                slot, index, least = self.margins.popleft()
                place = {"slot": slot, "index": index}
                margin = {"valid": 1, "place": place, "margin": least}
            if self.decisions and not stalls[4]:
                slot, is_walked = self.decisions.popleft()
                decision = {"valid": 1, "slot": slot, "walked": is_walked}
            ctx.set(dut.margin, margin)
            ctx.set(dut.decided, decision)
            gives = bool(self.due) and known and now >= self.due[0][0]
            # An offer stays until it is taken.
            gives &= not stalls[3] or ctx.get(dut.evaluated.valid)
            ctx.set(dut.evaluated.valid, gives)
            if gives:
                member = self.due[0][1]
                word = {"key": member.key, "slot": member.slot, "length": len(member.path)}
                ctx.set(dut.evaluated.payload, word)
            await self.tick(ctx)

    async def tick(self, ctx):
        dut = self.dut
        children, points, keys = dut.children, dut.points, dut.evaluated
        _, _, reset, *events, taken, child, point = await ctx.tick().sample(
            self.top.reset,
            *(dut.begin, dut.finish, dut.merge, dut.store, dut.fills, dut.ready, dut.pending),
            *(keys.ready, points.valid & points.ready, children.valid & children.ready),
            *(keys.valid & keys.ready, children.payload, points.payload),
        )
        if reset:
            return
        cycle = Cycle(*map(bool, events), self.due.popleft()[1].key if taken else None)
        self.cycles.append(cycle)
        if cycle.points:
            built = self.built[0]
            built.taken.append((point.x, point.y, point.altitude))
            if point.last:
                assert built.taken == built.points
                self.built.popleft()
                self.give(built.member, built.margins)
        if cycle.children:
            built = self.coming.popleft()
            assert (child.first, child.limited) == built.head[:2]
            assert not child.limited or child.limit == built.head[2]
            assert child.slot not in {other.slot for other in built.others}
            built.member.slot = child.slot
            self.built.append(built)

    def simulate(self, bench):
        simulate(self.top, bench, background=[self.around])


def _sorted(members):
    return sorted(members, key=lambda member: member.key)
