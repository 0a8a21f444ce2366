# amaranth: UnusedElaboratable=no
"""The scorer: scores and chords of its model, at full rate, under back-pressure, after a reset."""

import itertools
from dataclasses import dataclass, field

import numpy as np
import pytest
from amaranth.hdl import ResetInserter, Signal
from amaranth.sim import Simulator

from hdl.planner.scorer import scorer as module
from hdl.planner.scorer.scorer import Scorer
from hdl.protocol.planner import VALUE_BITS
from sim.model.planner.definition.score import score
from tests.planner_cases import SMALL, USUAL, path, record
from tests.scorer_cases import defined_score, drawn_paths, drawn_problem, problem_fields


@dataclass
class Job:
    """Paths of one problem, and what the scorer makes of them.

    Attributes
    ----------
    pauses : sequence of sequence of int
        Cycles before each transfer of points, scores and chords, repeated.
    reset_at : int or None
        Cycle of a reset, after which the job ends.
    scores : list of (infeasible, unlimited, value)
    chords : list of (point, point) or None
    taken, scored, offered : list of int
        Cycle in which each point was taken, and each score and chord.
    """

    problem: object
    paths: list
    gives_up: bool = False
    pauses: tuple = ((0,), (0,), (0,))
    reset_at: int | None = None
    scores: list = field(default_factory=list)
    chords: list = field(default_factory=list)
    taken: list = field(default_factory=list)
    scored: list = field(default_factory=list)
    offered: list = field(default_factory=list)

    def check(self):
        results = [defined_score(self.problem, each, self.gives_up) for each in self.paths]
        assert self.scores == [score for score, _ in results]
        assert self.chords == [chord for _, chords in results for chord in chords]


#: Cycles in which nothing may come after the last job.
IDLE = 150


def run(config, *jobs):
    """Run jobs on one scorer, each when the one before is done, and return them."""
    dut, reset = Scorer(config), Signal()
    simulator = Simulator(ResetInserter({"sync": reset})(dut))
    simulator.add_clock(1e-8)

    async def bench(ctx):
        for job in jobs:
            await drive(ctx, dut, job)
            if job.reset_at is not None:
                ctx.set(reset, 1)
                await ctx.tick()
                ctx.set(reset, 0)
        nothing = Job(None, [[]], reset_at=IDLE)
        await drive(ctx, dut, nothing)
        assert nothing.scored == nothing.offered == []

    simulator.add_testbench(bench)
    simulator.run()
    return jobs


async def drive(ctx, dut, job):
    """Send the points of a job, and take scores and chords until all are there."""
    streams = dut.points, dut.scores, dut.chords
    flags = [each.valid & each.ready for each in streams]
    pauses = [itertools.cycle(each) for each in job.pauses]
    left = [next(each) for each in pauses]
    points = [
        {"x": x, "y": y, "altitude": altitude, "last": i == len(each) - 1}
        for each in job.paths
        for i, (x, y, altitude) in enumerate(each)
    ]
    waypoints = len(points) - 2 * len(job.paths)
    if job.problem is not None:
        ctx.set(dut.problem, problem_fields(job.problem))
    ctx.set(dut.gives_up, job.gives_up)
    for cycle in range(100_000):
        if cycle == job.reset_at or (len(job.scored), len(job.offered)) == (
            len(job.paths),
            waypoints,
        ):
            return
        offers = len(job.taken) < len(points) and left[0] == 0
        ctx.set(dut.points.valid, offers)
        if offers:
            ctx.set(dut.points.p, points[len(job.taken)])
        ctx.set(dut.scores.ready, left[1] == 0)
        ctx.set(dut.chords.ready, left[2] == 0)
        moved = [ctx.get(flag) for flag in flags]
        if moved[0]:
            job.taken.append(cycle)
        if moved[1]:
            each = ctx.get(dut.scores.payload)
            job.scores.append((bool(each.infeasible), bool(each.unlimited), each.value))
            job.scored.append(cycle)
        if moved[2]:
            each = ctx.get(dut.chords.payload)
            ends = tuple((end.x, end.y, end.altitude) for end in each.ends)
            job.chords.append(ends if each.exists else None)
            job.offered.append(cycle)
        left = [
            next(each) if done else max(pause - 1, 0)
            for each, done, pause in zip(pauses, moved, left, strict=True)
        ]
        await ctx.tick()
    raise TimeoutError("The scorer does not end")


def drawn_job(config, rng, count, **options):
    problem = options.pop("problem", None) or drawn_problem(config, rng)
    return Job(problem, drawn_paths(config, rng, problem, count), **options)


# Small and usual chips; the largest in Verilator.
@pytest.mark.parametrize(
    ("config", "problems", "count"), [(SMALL, 6, 5), (USUAL, 2, 3)], ids=["small", "usual"]
)
def test_matches_the_definition(config, problems, count):
    rng = np.random.default_rng(problems)
    jobs = [drawn_job(config, rng, count, gives_up=bool(i % 2)) for i in range(problems)]
    for job in run(config, *jobs):
        job.check()


def test_matches_the_definition_under_back_pressure():
    """With pauses of random lengths in some of the streams: points, scores, chords."""
    rng = np.random.default_rng(4)
    jobs = []
    for stalled in ((0, 1), (2,), (0, 1, 2)):
        pauses = [
            rng.choice([0, 0, 1, 2, 15], 500).tolist() if i in stalled else (0,) for i in range(3)
        ]
        jobs.append(drawn_job(SMALL, rng, 5, pauses=pauses))
    for job in run(SMALL, *jobs):
        job.check()


def test_queues_never_overflow(monkeypatch):
    """With queues of few words, which fill up while nothing is taken."""
    monkeypatch.setattr(module, "CHORDS", 8)
    monkeypatch.setattr(module, "RESULTS", 3)
    rng = np.random.default_rng(3)
    problem = record(SMALL, rng, radius=300, climb=(1 << 24) - 1, descent=(1 << 24) - 1)
    jobs = [
        drawn_job(SMALL, rng, 7, problem=problem, pauses=pauses)
        for pauses in (((0,), (200, 40), (0,)), ((0,), (0,), (190, 0, 0, 15)))
    ]
    for job in run(SMALL, *jobs):
        job.check()
        assert job.taken[-1] > 200


def test_cycles():
    """A path of n points takes 2 n cycles, and latencies are those of the docstring."""
    rng = np.random.default_rng(5)
    lengths = [3, 4, 3, 10, 3, 4]
    problem = record(USUAL, rng)
    paths = [path(USUAL, rng, waypoints=length - 2) for length in lengths]
    # Alone, whichever the cycle of a slot in which the points come.
    alone = [Job(problem, paths[1:2], pauses=((wait, 0, 0, 0), (0,), (0,))) for wait in range(2)]
    together, *alone = run(USUAL, Job(problem, paths), *alone)
    together.check()
    # The first points fill a slot and a register.
    first_points = np.cumsum(lengths)[:-1]
    assert np.diff([together.taken[start] for start in first_points]).tolist() == [
        2 * length for length in lengths[1:-1]
    ]
    assert np.diff(together.scored).tolist() == [2 * length for length in lengths[1:]]
    for job in alone:
        *_, before, goal = job.taken
        found = job.offered[-2] - before, job.offered[-1] - goal, job.scored[0] - goal
        assert found == (90, 90, 145)


def test_a_point_may_come_at_any_time():
    """The second slot of a path follows the first, whenever the second point comes."""
    rng = np.random.default_rng(7)
    problem = record(SMALL, rng, radius=100)
    pauses = ((1, 0), (0, 1), (3, 2))
    jobs = [
        drawn_job(SMALL, rng, 2, problem=problem, pauses=((*each, 0), (0,), (0,)))
        for each in pauses
    ]
    for job in run(SMALL, *jobs):
        job.check()


def test_reset_discards_all_paths():
    """Paths that are inside when the reset comes leave nothing behind."""
    rng = np.random.default_rng(8)
    problem = record(SMALL, rng, radius=100)
    jobs = [
        drawn_job(SMALL, rng, 8 if i % 2 == 0 else 2, problem=problem, reset_at=reset_at)
        for i, reset_at in enumerate((61, None, 140, None))
    ]
    for job in run(SMALL, *jobs)[1::2]:
        job.check()


def test_greatest_costs():
    """Values end at 0 and at their greatest; a cost beyond every key is told apart."""
    rng = np.random.default_rng(9)
    limits = {"climb": (1 << 24) - 1, "descent": (1 << 24) - 1, "radius": 0}
    straight = [(x, x, 100) for x in (0, 10, 20, 30)]
    jobs = {}
    for key_shift in range(64):
        for base in (-(1 << 24), (1 << 24) - 1):
            problem = record(
                SMALL, rng, **limits, key_shift=key_shift, base=base, fuel=65_535, fuel_shift=0
            )
            (infeasible, unlimited, value), _ = defined_score(problem, straight, False)
            assert not infeasible
            kind = unlimited, value in (0, (1 << VALUE_BITS) - 1)
            jobs[kind] = Job(problem, [straight])
    assert jobs.keys() == {(False, False), (False, True), (True, True)}
    for job in run(SMALL, *jobs.values()):
        job.check()


def test_steep_arcs_count_last_while_the_best_path_is_feasible():
    """Beside another penalty they do not count then; alone they always do."""
    rng = np.random.default_rng(10)
    kinds = {True: [], False: []}
    while not all(len(each) >= 2 for each in kinds.values()):
        problem = drawn_problem(SMALL, rng)
        for points in drawn_paths(SMALL, rng, problem, 5):
            scored = score(problem, points)
            if scored.steep_arcs:
                kinds[scored.penalty > 0].append((problem, points))
    chosen = [kinds[True][0], kinds[False][0]]
    jobs = [
        Job(problem, [points], gives_up=gives_up)
        for problem, points in chosen
        for gives_up in (False, True)
    ]
    both, not_both, alone, still_alone = run(SMALL, *jobs)
    for job in jobs:
        job.check()
    assert both.scores != not_both.scores
    assert alone.scores == still_alone.scores
