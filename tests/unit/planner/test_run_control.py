"""Steps of runs with units that take arbitrary numbers of cycles: all pulses, cycle by cycle.

Limits of a run: counters, parts of an island, and the cycle in which a limit is reached.
"""

import random
from dataclasses import dataclass

import pytest

from pathgene.hdl.planner.first_paths import FirstPathKind
from pathgene.hdl.planner.run_control import RunControl, RunLimits
from pathgene.sim.model.planner import run_cycles as steps
from tests.support.gateware.streams import pulse, shared, simulate
from tests.support.planner.cases import SMALL


SHARE_BITS = 5


class Bench:
    """A unit of counters of ``bits``, and its numbers cycle by cycle."""

    def __init__(self, bits):
        self.dut = shared(RunLimits, bits, SHARE_BITS)

    async def launch(self, ctx, cycles, generations, share):
        dut = self.dut
        ctx.set(dut.most_cycles, cycles)
        ctx.set(dut.most_generations, generations)
        ctx.set(dut.share, share)
        await pulse(ctx, dut.launch)
        ctx.set(dut.running, 1)


@pytest.mark.parametrize("bits", [6, 32])
def test_parts_of_islands(bits):
    bench, rng, most = Bench(bits), random.Random(bits), (1 << bits) - 1
    dut = bench.dut

    def number():
        return rng.choice([0, most, rng.randrange(most + 1)])

    async def run(ctx):
        for _ in range(200):
            cycles, generations, share = number(), number(), rng.choice([0, 16, 31, 13])
            await bench.launch(ctx, cycles, generations, share)
            bred = rng.randrange(5)
            for _ in range(bred):
                await pulse(ctx, dut.bred)
            await ctx.tick().repeat(rng.randrange(1, 40))
            now = ctx.get(dut.cycles)
            await pulse(ctx, dut.split)
            for _ in range(SHARE_BITS):
                assert ctx.get(dut.splitting)
                await ctx.tick()
            assert not ctx.get(dut.splitting)
            begun = ctx.get(dut.cycles)
            assert begun == min(now + 1 + SHARE_BITS, most)
            limit = min(begun + (max(cycles - now, 0) * share >> SHARE_BITS), most)
            limit_of_generations = min(bred + (generations * share >> SHARE_BITS), most)
            await pulse(ctx, dut.aim)
            await ctx.tick()
            for _ in range(10):
                # They follow from the numbers of the previous cycle.
                before = min(ctx.get(dut.cycles), most), ctx.get(dut.generations)
                await ctx.tick()
                reached = before[0] >= limit or before[1] >= limit_of_generations
                assert ctx.get(dut.reached) == reached
            ctx.set(dut.running, 0)

    simulate(dut, run)


def test_limits_of_the_run():
    bench = Bench(8)
    dut = bench.dut

    async def run(ctx):
        for cycles, generations, stops, waits, expected in (
            (40, 255, None, 0, 41),
            (255, 3, None, 0, 31),
            (255, 3, None, 20, 31),
            (255, 3, None, 50, 51),
            (40, 3, None, 50, 41),
            (255, 3, 35, 50, 37),
            (255, 0, None, 0, 5),
            (0, 255, None, 0, 5),
            (255, 255, 20, 0, 22),
            (255, 255, None, 0, 256),
        ):
            await bench.launch(ctx, cycles, generations, 0)
            ctx.set(dut.final, 1)
            number = 0
            while number < 5 or not ctx.get(dut.reached):
                assert ctx.get(dut.cycles) == min(number, 255)
                assert ctx.get(dut.generations) == number // 10
                ctx.set(dut.aim, number == 3)
                ctx.set(dut.bred, number % 10 == 9)
                ctx.set(dut.stop, number == stops)
                ctx.set(dut.waits, number < waits)
                await ctx.tick()
                number += 1
            assert number == expected
            ctx.set(dut.running, 0)
            ctx.set(dut.stop, 1)  # It has no meaning now.
            await ctx.tick()
            ctx.set(dut.stop, 0)
            assert ctx.get(dut.cycles) == min(number, 255)

    simulate(dut, run)


PULSES = ("launch", "clear", "find_route", "make_paths", "store", "begin", "finish", "merge")


@dataclass
class Options:
    cycles: int
    generations: int
    slopes: tuple
    lifts: int
    share: int
    warm: bool
    until_feasible: bool
    feasible_from: int
    stop: int | None = None
    seeds: int = 20
    seed: int = 1234567
    give_up_rank: int = 3
    guided: int = 0

    def fields(self):
        values = {
            name: value
            for name, value in vars(self).items()
            if name not in ("stop", "slopes", "feasible_from")
        }
        slopes = {f"slope_{i}": slope for i, slope in enumerate(self.slopes)}
        return values | slopes | {"islands": len(self.slopes)}


class Durations:
    """Cycles of the requests to the units, in their order."""

    def __init__(self, seed):
        self._rng = random.Random(seed)

    def draw(self, name):
        """Return the cycles from a pulse to the first one in which the unit is done."""
        low, high = {"launch": (30, 60), "begin": (2, 60)}.get(name, (2, 30))
        return self._rng.randint(low, high)


def expected_of(options, durations):
    """Return the pulses of a run with their cycles and payloads, and its cycles."""
    events = []
    generations = 0

    def pulse(cycle, name, *more):
        events.append((cycle, name, *more))
        return cycle + durations.draw(name)

    done = pulse(0, "launch", not options.warm)
    cycle = done + steps.SCANNED - 1
    count = len(options.slopes) + options.warm
    for island in range(count):
        kind = FirstPathKind.REVIVED if options.warm and island == 0 else FirstPathKind.SEED
        lifts = 0
        if kind is FirstPathKind.SEED:
            lifts = options.lifts
            slope = options.slopes[island - options.warm]
            by_turns = island == 0
            if not (options.guided and island == options.warm):
                cycle = pulse(cycle, "find_route", slope, by_turns) + steps.ROUTED - 1
        for number in range(1 + lifts):
            kind = FirstPathKind.LIFTED if number else kind
            paths, guided = SMALL.population, None
            if kind is FirstPathKind.SEED:
                paths = options.seeds
                guided = options.guided if island == options.warm else 0
            done = pulse(cycle, "make_paths", kind, paths, guided)
            done = pulse(done + steps.EVALUATED, "store", island)
            cycle = done + steps.POPULATION

    def evolve(cycle, island, most_cycles, most_generations, is_final=False):
        nonlocal generations
        pending = False
        while True:
            stopped = options.stop is not None and options.stop < cycle
            now = cycle + steps.BEGIN
            waits = is_final and options.until_feasible and cycle < options.feasible_from
            bred = generations >= most_generations and not waits
            if stopped or cycle >= most_cycles or bred:
                if pending:
                    return pulse(now, "finish", island)
                return cycle
            cycle = pulse(now, "begin", island)
            generations += 1
            pending = True

    if count == 2:
        left = max(options.cycles - cycle, 0)
        parts = left * options.share >> 5, options.generations * options.share >> 5
        cycle += steps.SPLIT_TO_AIM
        for island in range(2):
            limits = cycle + parts[0], generations + parts[1]
            cycle = evolve(cycle + steps.AIMED, island, *limits) + steps.NEXT_ISLAND
        cycle += steps.MERGED[0] - steps.NEXT_ISLAND
        done = pulse(cycle, "merge")
        cycle = max(cycle + steps.MERGED[1] + steps.AIMED, done)
    else:
        cycle += steps.AIMED
    cycle = evolve(cycle, 0, options.cycles, options.generations, is_final=True) + steps.END
    return events, cycle, generations


async def run_once(ctx, dut, options, durations, rng):
    """Do a run; return its pulses and its cycles."""
    ctx.set(dut.runs.valid, 1)
    ctx.set(dut.runs.payload, options.fields())
    while not ctx.get(dut.runs.ready):
        await ctx.tick()
    assert ctx.get(dut.phase)
    await ctx.tick()
    ctx.set(dut.runs.valid, 0)
    cycle, events, spread = 0, [], 0
    # First cycles in which units are done.
    seeds = memo = source = paths = evaluated = evolver = -1
    while ctx.get(dut.running):
        assert ctx.get(dut.phase) == cycle % 2
        assert ctx.get(dut.cycles) == cycle
        assert not ctx.get(dut.runs.ready)
        since = events[-1][0] if events else -9
        ctx.set(dut.seeds_busy, cycle < seeds)
        ctx.set(dut.memo_busy, cycle < memo)
        ctx.set(dut.source_ready, cycle >= source)
        ctx.set(dut.paths_busy, cycle < paths)
        ctx.set(dut.evaluator_idle, cycle >= evaluated or (cycle < paths and rng.random() < 0.5))
        # The flags in the cycle after a pulse have no meaning.
        ready = rng.random() < 0.5 if cycle == since + 1 else cycle >= evolver
        ctx.set(dut.evolver_ready, ready)
        ctx.set(dut.feasible, cycle >= options.feasible_from)
        ctx.set(dut.stop, cycle == options.stop)
        spread += ctx.get(dut.spreading)
        kind, island = ctx.get(dut.kind), ctx.get(dut.island)
        for name in PULSES:
            if not ctx.get(getattr(dut, name)) or name == "clear":
                continue
            done = cycle + durations.draw(name)
            if name == "launch":
                events.append((cycle, name, bool(ctx.get(dut.clear))))
                seeds = done
                memo, source = (cycle + rng.randrange(2, 10) for _ in range(2))
            elif name == "find_route":
                events.append((cycle, name, ctx.get(dut.slope), bool(ctx.get(dut.by_turns))))
                seeds = done
            elif name == "make_paths":
                guided = ctx.get(dut.guided) if kind is FirstPathKind.SEED else None
                events.append((cycle, name, kind, ctx.get(dut.count), guided))
                evaluated, paths = done, rng.randint(cycle + 2, done)
            else:
                events.append((cycle, name, island) if name != "merge" else (cycle, name))
                evolver = done
                assert ctx.get(dut.fills) == (name == "store")
        ended = ctx.get(dut.ends)
        await ctx.tick()
        cycle += 1
        assert ctx.get(dut.running) == (not ended)
        assert cycle < 20_000
    return events, cycle, spread


def drawn_options(rng):
    warm = rng.random() < 0.4
    slopes = [rng.randrange(16) for _ in range(rng.randrange(1 - warm, 3 - warm))]
    return Options(
        cycles=rng.choice([0, 200, 600, 1500, 2500]),
        generations=rng.choice([0, 3, 10, 1 << 31]),
        slopes=tuple(slopes),
        lifts=rng.randrange(5),
        share=rng.randrange(17),
        warm=warm,
        guided=rng.choice([0, 2, 5]) if slopes else 0,
        until_feasible=rng.random() < 0.5,
        feasible_from=rng.choice([0, rng.randrange(2500), 1 << 31]),
        stop=rng.choice([None, None, rng.randrange(2000)]),
    )


@pytest.mark.ci
@pytest.mark.parametrize("seed", range(4))
def test_steps_of_runs(seed):
    dut, rng = RunControl(SMALL), random.Random(seed)
    kinds = set()

    async def bench(ctx):
        for number in range(25):
            options = drawn_options(rng)
            for _ in range(rng.randrange(4)):
                await ctx.tick()
            ctx.set(dut.stop, rng.randrange(2))  # It has no meaning now.
            found = await run_once(ctx, dut, options, Durations(number), rng)
            expected, cycles, generations = expected_of(options, Durations(number))
            assert found[0] == expected, options
            assert found[1] == cycles == ctx.get(dut.cycles)
            assert ctx.get(dut.generations) == generations
            fields = ctx.get(dut.options)
            assert fields.seed == options.seed
            assert fields.give_up_rank == options.give_up_rank
            kinds.add((len(options.slopes), options.warm, generations > 0))
            routes = Durations(number)
            durations = [routes.draw(event[1]) for event in expected]
            # Cycles in which the source of seeds is busy.
            assert found[2] == sum(
                each - 1
                for each, event in zip(durations, expected, strict=True)
                if event[1] in ("launch", "find_route")
            )

    simulate(dut, bench)
    assert len(kinds) >= 6
