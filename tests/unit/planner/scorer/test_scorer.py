"""The scorer: scores and chords of its model, cycle by cycle, with pauses, after a reset."""

import dataclasses
import itertools
from dataclasses import dataclass, field

import numpy as np
import pytest
from amaranth.hdl import Fragment

from pathgene.hdl.planner.scorer.scorer import Scorer
from pathgene.hdl.protocol.planner import POSITION_FRACTION, SCALE_FRACTION, VALUE_BITS
from pathgene.sim.model.planner.definition.score import score
from pathgene.sim.model.planner.evaluator_cycles import ScorerCycles, freed, launched
from tests.support.gateware.streams import resettable, shared, simulate
from tests.support.planner.cases import SMALL, USUAL, headed, path, record
from tests.support.planner.scorer_cases import (
    defined_score,
    drawn_free_problem,
    drawn_paths,
    drawn_problem,
    problem_fields,
)


#: Maximum slopes, which no path exceeds.
GENTLE = {"climb": (1 << 24) - 1, "descent": (1 << 24) - 1}

#: Room in every cycle of a job.
OPEN = [1] * 1000
#: Without and with an entry, and an exit.
ENDS = list(itertools.product((0, 1), repeat=2))


@dataclass
class Job:
    """Paths of one problem, and their results from the scorer.

    Attributes
    ----------
    pauses : sequence of int
        Cycles before each transfer of a point, repeated.
    room : sequence of int
        Room in each cycle, repeated.
    reset_at : int or None
        Cycle of a reset, after which the job ends.
    begins : int
        First cycle; slots of two cycles end in odd ones.
    chords, scores : list of tuple
        Cycle, then ``last`` and the chord, or ``infeasible`` and ``value``.
    taken, launches : list of int
        Cycle in which each point was taken, and in which each path was launched.
    """

    problem: object
    paths: list
    pauses: tuple = (0,)
    room: tuple = (1,)
    reset_at: int | None = None
    begins: int = 0
    chords: list = field(default_factory=list)
    scores: list = field(default_factory=list)
    taken: list = field(default_factory=list)
    launches: list = field(default_factory=list)

    @property
    def added(self):
        """Points that are added to every path."""
        return self.problem.has_entry + self.problem.has_exit

    def check(self):
        """Compare everything but cycles; a score follows the chords of its path."""
        results = [defined_score(self.problem, each) for each in self.paths]
        assert [each[1:] for each in self.scores] == [score for score, _ in results]
        assert [each[1:] for each in self.chords] == [
            (i == len(chords) - 1, chord) for _, chords in results for i, chord in enumerate(chords)
        ]
        ends = [cycle for cycle, last, _ in self.chords if last]
        assert all(end < cycle for end, (cycle, *_) in zip(ends, self.scores, strict=True))

    def check_cycles(self, config):
        """Compare the cycles of chords and scores with the cycles of the launches."""
        cycles = ScorerCycles.of(config)
        sizes = [len(each) + self.added for each in self.paths]
        begun = list(zip(self.launches, sizes, strict=True))
        assert [each[0] for each in self.scores] == [cycles.scored(*each) for each in begun]
        assert [each[0] for each in self.chords] == [
            cycles.sent(start, segment) for start, size in begun for segment in range(size - 1)
        ]


#: Cycles after the last job in which nothing may be output.
IDLE = 170

#: Chips with slots of one and of two cycles.
SMALLS = [SMALL.replace(point_cycles=cycles) for cycles in (1, 2)]
USUALS = [USUAL.replace(point_cycles=cycles) for cycles in (1, 2)]
BOTH_SLOTS = pytest.mark.parametrize("config", SMALLS, ids=["one cycle", "two cycles"])


def run(config, *jobs):
    """Run jobs on one scorer, each when the previous one is done, and return them."""
    dut = shared(Scorer, config)
    top, reset = resettable(dut)

    async def bench(ctx):
        cycle = 0
        for job in jobs:
            job.begins = cycle
            cycle = await drive(ctx, dut, job)
            if job.reset_at is not None:
                ctx.set(reset, 1)
                ctx.set(dut.phase, cycle % 2)
                await ctx.tick()
                cycle += 1
                ctx.set(reset, 0)
        nothing = Job(None, [[]], reset_at=IDLE, begins=cycle)
        await drive(ctx, dut, nothing)
        assert nothing.scores == nothing.chords == []

    simulate(top, bench)
    return jobs


def points_of(paths):
    """Return the points of all paths in the form that the scorer accepts."""
    return [
        {"x": x, "y": y, "altitude": altitude, "last": i == len(each) - 1}
        for each in paths
        for i, (x, y, altitude) in enumerate(each)
    ]


async def drive(ctx, dut, job):
    """Send the points of a job until all scores are available; return the next cycle."""
    points = points_of(job.paths)
    pauses, rooms = itertools.cycle(job.pauses), itertools.cycle(job.room)
    left = next(pauses)
    if job.problem is not None:
        ctx.set(dut.problem, problem_fields(job.problem))
    for cycle in range(job.begins, job.begins + 100_000):
        ended = len(job.scores) == len(job.paths)
        if ended or cycle - job.begins == job.reset_at:
            ctx.set(dut.points.valid, 0)
            return cycle
        ctx.set(dut.phase, cycle % 2)
        ctx.set(dut.room, next(rooms))
        offers = len(job.taken) < len(points) and left == 0
        ctx.set(dut.points.valid, offers)
        if offers:
            ctx.set(dut.points.p, points[len(job.taken)])
        left = max(left - 1, 0)
        if offers and ctx.get(dut.points.ready):
            job.taken.append(cycle)
            left = next(pauses)
        read(ctx, dut, job, cycle)
        await ctx.tick()
    raise TimeoutError("The scorer does not end")


def read(ctx, dut, job, cycle):
    """Add the outputs of the scorer in this cycle."""
    if ctx.get(dut.launches):
        job.launches.append(cycle)
    each = ctx.get(dut.chord)
    if each.valid:
        chord = tuple((end.x, end.y, end.altitude) for end in (each.start, each.stop))
        job.chords.append((cycle, bool(each.last), chord if each.present else None))
    each = ctx.get(dut.score)
    if each.valid:
        job.scores.append((cycle, bool(each.infeasible), each.value))


def drawn_job(config, rng, count, **options):
    problem = options.pop("problem", None) or drawn_problem(config, rng)
    return Job(problem, drawn_paths(config, rng, problem, count), **options)


def with_ends(config, rng, problem, entry, exits):
    """Return the problem with an entry or without, with an exit or without."""
    drawn = headed(config, rng, problem)
    return dataclasses.replace(drawn, has_entry=entry, has_exit=exits)


# Small and usual chips; the largest in Verilator.
@pytest.mark.parametrize("ends", ENDS, ids=["free", "exit", "entry", "both"])
@pytest.mark.parametrize(
    ("config", "problems", "count"),
    [*((config, 5, 5) for config in SMALLS), *((config, 1, 3) for config in USUALS)],
    ids=["small", "small, two cycles", "usual", "usual, two cycles"],
)
def test_matches_the_definition(config, problems, count, ends):
    """Paths follow each other at full rate, with and without entry and exit."""
    rng = np.random.default_rng(ends)
    free = [drawn_free_problem(config, rng) for _ in range(problems)]
    jobs = [
        drawn_job(config, rng, count, problem=with_ends(config, rng, each, *ends)) for each in free
    ]
    for job in run(config, *jobs):
        job.check()
        job.check_cycles(config)
        sizes = [config.point_cycles * (len(each) + sum(ends)) for each in job.paths]
        assert np.diff(job.launches).tolist() == sizes[:-1]


@pytest.mark.ci
@BOTH_SLOTS
def test_matches_the_definition_with_pauses(config):
    """Points and room come with pauses."""
    rng = np.random.default_rng(4)
    jobs = []
    for _ in range(3):
        pauses = rng.choice([0, 0, 1, 2, 15], 500).tolist()
        jobs.append(drawn_job(config, rng, 5, pauses=pauses))
        room = np.repeat(rng.integers(2, size=200), rng.integers(1, 60, size=200)).tolist()
        jobs.append(drawn_job(config, rng, 5, room=room))
        room = rng.integers(2, size=500).tolist()
        jobs.append(drawn_job(config, rng, 5, pauses=pauses, room=room))
    for job in run(config, *jobs):
        job.check()
    for job in jobs[1::3]:
        job.check_cycles(config)


@pytest.mark.ci
@BOTH_SLOTS
def test_shortest_and_longest_paths(config):
    """Paths of only start and goal alternate with paths of the maximum number of points."""
    rng = np.random.default_rng(11)
    jobs = []
    for ends in ENDS:
        problem = with_ends(SMALL, rng, record(SMALL, rng, radius=60, **GENTLE), *ends)
        paths = [path(SMALL, rng, waypoints=count) for count in (0, 0, 5, 0, 1, 5, 5, 0)]
        jobs.append(Job(problem, paths))
        jobs.append(Job(problem, paths, pauses=(0, 3, 0, 1, 0)))
    for job in run(config, *jobs):
        job.check()
        if job.pauses == (0,):
            job.check_cycles(config)


@pytest.mark.parametrize("point_cycles", [1, 2])
@pytest.mark.parametrize("altitude_bits", [6, 9, 12, 16])
@pytest.mark.parametrize("map_size", [16, 128, 512, 4096])
def test_latencies(map_size, altitude_bits, point_cycles):
    """Model and gateware agree in all sizes."""
    for waypoints in (4, 64):
        config = USUAL.replace(
            map_size=map_size,
            coarse_factor=4,
            altitude_bits=altitude_bits,
            max_waypoints=waypoints,
            point_cycles=point_cycles,
        )
        scorer = Scorer(config)
        Fragment.get(scorer, None)
        latencies = scorer.chord_latency, scorer.score_latency, point_cycles
        assert latencies == dataclasses.astuple(ScorerCycles.of(config))


@pytest.mark.parametrize(
    ("config", "chord", "score", "scored"),
    [(USUALS[0], 73, 50, 121), (USUALS[1], 87, 56, 139)],
    ids=["one cycle", "two cycles"],
)
def test_cycles(config, chord, score, scored):
    """The numbers in the docstring hold for a lone path in the default sizes."""
    rng = np.random.default_rng(5)
    problem = with_ends(config, rng, record(config, rng), 1, 1)
    (job,) = run(config, Job(problem, [path(config, rng, waypoints=4)]))
    job.check()
    (start,) = job.launches
    slot = config.point_cycles
    sent = [chord + slot * segment for segment in range(7)]
    assert [cycle - start for cycle, *_ in job.chords] == sent
    assert job.scores[0][0] - start == sent[-1] + score == slot * 8 + scored
    # The first two points together, then one in every slot, after the entry point.
    assert [cycle - start for cycle in job.taken] == [-1, *range(slot, 5 * slot + 1, slot)]


@pytest.mark.ci
@BOTH_SLOTS
@pytest.mark.parametrize("ends", ENDS, ids=["free", "exit", "entry", "both"])
def test_a_path_begins(ends, config):
    """It begins in the cycle given by the model, whenever points arrive and room is available."""
    rng = np.random.default_rng(7)
    problem = with_ends(SMALL, rng, record(SMALL, rng, radius=100), *ends)
    jobs = []
    for _ in range(16):
        pauses = *rng.integers(4, size=2).tolist(), *[0] * 5
        room = [0] * int(rng.choice([0, 1, 2, 3, 8, 9])) + OPEN
        paths = [path(SMALL, rng, waypoints=2)]
        jobs.append(Job(problem, paths, pauses, room))
    for job in run(config, *jobs):
        job.check()
        job.check_cycles(config)
        first = job.begins + job.pauses[0]
        second = first + 1 + job.pauses[1]
        room = job.begins + job.room.index(1)
        assert job.launches == [launched(first, second, 0, room, config.point_cycles)]


@pytest.mark.ci
@BOTH_SLOTS
def test_the_next_path_begins(config):
    """A path begins right after the previous one, or later if points or room are late."""
    rng = np.random.default_rng(12)
    problem = with_ends(SMALL, rng, record(SMALL, rng, radius=100), 1, 1)
    jobs = []
    for late, closed in itertools.product((0, 5, 6, 7, 8, 13), (0, 13, 14, 20)):
        paths = [path(SMALL, rng, waypoints=2), path(SMALL, rng, waypoints=1)]
        room = [1, 1, 1] + [0] * closed + OPEN
        jobs.append(Job(problem, paths, (0, 0, 0, 0, late, 0, 0, 0), room))
    slot = config.point_cycles
    for job in run(config, *jobs):
        job.check()
        job.check_cycles(config)
        goal = job.taken[3]
        first = goal + 1 + job.pauses[4]
        room = job.begins + len(job.room) - len(OPEN)
        start = launched(job.begins, job.begins + 1, 0, job.begins, slot)
        free = freed(start, 6, slot)
        assert job.launches == [start, launched(first, first + 1, free, room, slot)]


@BOTH_SLOTS
def test_reset_discards_all_paths(config):
    """Paths that are inside during a reset do not leave a trace."""
    rng = np.random.default_rng(8)
    problem = with_ends(SMALL, rng, record(SMALL, rng, radius=100), 1, 1)
    jobs = [
        drawn_job(config, rng, 8 if i % 2 == 0 else 2, problem=problem, reset_at=reset_at)
        for i, reset_at in enumerate((61, None, 140, None))
    ]
    for job in run(config, *jobs)[1::2]:
        job.check()
        job.check_cycles(config)


@BOTH_SLOTS
def test_greatest_costs(config):
    """Values are clamped at 0 and at their maximum."""
    rng = np.random.default_rng(9)
    straight = [(x, x, 100) for x in (0, 10, 20, 30)]
    jobs = {}
    for key_shift in range(64):
        for base, fuel in ((-(1 << 24), 0), ((1 << 24) - 1, 65_535)):
            fields = {"base": base, "fuel": fuel, "fuel_shift": 0, "key_shift": key_shift}
            problem = record(SMALL, rng, radius=0, **fields, **GENTLE)
            cost = score(problem, straight).cost >> key_shift
            assert score(problem, straight).penalty == 0
            kind = min(max(cost, -1) >> VALUE_BITS, 1)
            jobs[kind] = Job(problem, [straight])
    assert jobs.keys() == {-1, 0, 1}
    for job in run(config, *jobs.values()):
        job.check()


@BOTH_SLOTS
def test_steep_arcs_count_beside_steep_segments(config):
    """The arc of a right angle between climbs at the limit is steeper than they are."""
    rng = np.random.default_rng(10)
    far = 10 << POSITION_FRACTION
    ends = {"start_x": 0, "start_y": 0, "start_altitude": 1600, "goal_x": far, "goal_y": far}
    points = [(0, 0, 100), (10, 0, 110), (10, 10, 120)]
    fields = {"x_scale": 1 << SCALE_FRACTION, "climb": 256, "radius": 512}
    # A climb at the limit, and a climb of one part more.
    jobs = [
        Job(record(SMALL, rng, **ends, **fields, goal_altitude=altitude), [points])
        for altitude in (1920, 1921)
    ]
    for job in run(config, *jobs):
        job.check()
    assert [job.scores[0][2] for job in jobs] == [804, 804 + 64 + 4]
