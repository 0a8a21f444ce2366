"""Run time of the flower pollination algorithm: figures 9 and 10 of *roberge*."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from statistics import fmean, median
from typing import Any, NamedTuple

from bench.campaign import measure
from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import problem_at_one_cell
from pathgene.host.errors import InputError, PathgeneError
from pathgene.host.evaluation import Evaluator
from pathgene.host.machine import available_cores
from pathgene.host.planners.base import Options, Result
from pathgene.host.planners.fpa.planner import FlowerPollinationPlanner


MAP = "canyon"
#: Table 3.
ITERATIONS, POPULATION = 500, 512
#: Numbers of solutions, for all cores and the GPU.
SOLUTIONS = (64, 128, 256, 512, 1024, 2048, 4096)
#: Numbers of simultaneous runs on the GPU.
TOGETHER = 64
_REPEATS = 3
# Not an engine, but all threads with every candidate evaluated in full, as in the paper.
_IN_FULL = "all in full"
# Seconds during which the GPU's power is measured, and milliseconds between two readings.
_POWER_S, _POWER_MS = 2.0, 20
# Numba uses the first GPU.
_NVIDIA_SMI = ("nvidia-smi", "--id=0")

#: Section 5.3: engine, threads, solutions, seconds. 36 threads ran 9.6 times as fast as one.
PAPER = (
    ("paper: Xeon W-2195, 1 thread", 1, 512, 78.4),
    ("paper: Xeon W-2195, 18 cores", 36, 512, 8.1),
    ("paper: RTX A6000", "-", 512, 1.14),
)


class _Case(NamedTuple):
    """A row: an engine, its threads, the solutions of a run, and the simultaneous runs."""

    engine: str
    threads: int
    solutions: int
    runs: int = 1

    @property
    def name(self) -> str:
        """Name of the row for ``--only``."""
        return f"{self.engine}, {self.threads} threads, {self.solutions} x {self.runs}"


def run(
    options: BenchOptions,
    *,
    iterations: int = ITERATIONS,
    population: int = POPULATION,
    solutions: Sequence[int] = SOLUTIONS,
    together: int = TOGETHER,
) -> Report:
    """Time fpa-2opt by threads and by solutions, on each available engine.

    ``options.only`` selects rows, for example "gpu, 2 threads, 4096 x 64".
    """
    report = Report(
        f"fpa-2opt on {MAP}: {iterations} iterations, 6 free waypoints, ds one cell, paper mode",
        (
            "engine",
            "threads",
            "solutions",
            "runs at once",
            "seconds",
            "of iterations",
            "times as fast",
            "full evaluations/s",
            "all candidates/s",
            "mean F",
            "feasible",
            "joules a run",
        ),
    )
    cores = available_cores()
    every = [*_cases(cores, population, solutions, together)]
    tasks = [
        (case, iterations, case.solutions == population)
        for case in every
        if options.only in case.name
    ]
    if not tasks:
        raise InputError(f"No row of the benchmark has {options.only!r} in its name.")
    rows: dict[_Case, tuple[Any, ...]] = {}
    left_out: dict[str, None] = {}

    def failed(task: tuple[_Case, int, bool], error: PathgeneError) -> None:
        # Without a GPU, its rows have the same reason.
        is_missing = isinstance(error, InputError)
        said = "No GPU was measured" if is_missing else f"{task[0].name} was not measured"
        left_out[f"{said}. {error}"] = None

    # One at a time, in a process without earlier threads: each row has the machine for itself.
    measure(
        "roberge-speed",
        tasks,
        _measured,
        name=lambda task: task[0].name,
        keep=lambda task, row: rows.update({task[0]: row}),
        failed=failed,
        spawned=True,
        processes=1,
    )
    base_s = next(iter(rows.values()))[0] if rows else 0.0
    for case, (seconds, of_iterations, *rest) in rows.items():
        faster = base_s * case.runs / seconds if case.solutions == population else "-"
        threads = "-" if case.engine == "gpu" else case.threads
        report.rows.append((case.engine, threads, *case[2:], seconds, of_iterations, faster, *rest))
    if cores > 1 and not options.only:
        alone = measure(
            "roberge-speed",
            [(_Case("sequential", 1, population), iterations, False)] * cores,
            _measured,
            name=lambda _: "sequential, one a core",
            spawned=True,
        )
        seconds = median(row[0] for row in alone)
        name = "sequential, one a core"
        faster = cores * base_s / seconds
        report.rows.append((name, cores, population, cores, seconds, "-", faster, *("-",) * 5))
    report.rows += [
        (name, threads, count, 1, seconds, "-", PAPER[0][3] / seconds, *("-",) * 5)
        for name, threads, count, seconds in PAPER
    ]
    report.notes = [
        f"Median of {_REPEATS} after one that compiles, each with its own seeds; seconds from the "
        "first path drawn to the reported path, checked at ds / 8. Times as fast: runs a second, "
        "compared with the first row, and for the paper with its first row. One a core: "
        "independent runs at the same time, which show the limit of the machine. The paper gives "
        "neither its number of waypoints nor its ds. All candidates include candidates that are "
        'given up once they cannot be better; the row "all in full" evaluates them to the end, as '
        "the paper does. Rates: of the seconds of iterations. Joules: the GPU's power by "
        f"nvidia-smi over {_POWER_S:g} s of such runs, its power when idle included.",
        *_gpu_names(),
        *left_out,
    ]
    return report


def _cases(cores: int, population: int, solutions: Sequence[int], together: int) -> Iterator[_Case]:
    """Yield the processor's rows, then the GPU's."""
    yield _Case("sequential", 1, population)
    yield _Case(_IN_FULL, cores, population)
    for threads in range(1, cores + 1):
        yield _Case("threads", threads, population)
    others = [count for count in solutions if count != population]
    for count in others:
        yield _Case("threads", cores, count)
    for runs in (1, together):
        for count in (population, *others):
            yield _Case("gpu", cores, count, runs)


def _measured(case: _Case, iterations: int, watts: bool) -> tuple[Any, ...]:
    """Return the columns of a case, starting with its seconds."""
    rounds = [
        _plan(case, iterations, range(number * case.runs, (number + 1) * case.runs))
        for number in range(_REPEATS + 1)
    ][1:]  # The first run compiles.
    results = [result for results in rounds for result in results]
    joules: float | str = "-"
    if case.engine == "gpu" and watts:
        mean_w, seconds = _power(lambda: _plan(case, iterations, range(case.runs)))
        joules = "-" if mean_w is None else mean_w * seconds / case.runs
    return (
        median(results[0].seconds["total"] for results in rounds),
        median(results[0].seconds["iterations"] for results in rounds),
        median(_rate(results, lambda result: result.evaluations) for results in rounds),
        median(
            _rate(results, lambda result: result.evaluations + result.cut_short)
            for results in rounds
        ),
        fmean(result.evaluation.fitness for result in results),
        f"{sum(result.evaluation.feasible for result in results)}/{len(results)}",
        joules,
    )


def _plan(case: _Case, iterations: int, seeds: Sequence[int]) -> list[Result]:
    """Return the results of the runs of a case, each with its seed."""
    in_full = case.engine == _IN_FULL
    planner = FlowerPollinationPlanner(
        engine="threads" if in_full else case.engine, give_up=not in_full
    )
    evaluator = Evaluator(problem_at_one_cell(MAP), threads=case.threads)
    options = [
        Options(generations=iterations, population=case.solutions, seed=seed) for seed in seeds
    ]
    if case.runs > 1:
        return planner.plan_together([evaluator] * case.runs, options)
    return [planner.plan(evaluator, options[0])]


def _rate(results: Sequence[Result], count: Callable[[Result], int]) -> float:
    return sum(map(count, results)) / results[0].seconds["iterations"]


def _power(work: Callable[[], object]) -> tuple[float | None, float]:
    """Return the GPU's mean power in watts while ``work`` is repeated, and its seconds.

    The power is None if nvidia-smi does not report it.
    """
    command = [*_NVIDIA_SMI, "--query-gpu=power.draw.instant", "--format=csv,noheader,nounits"]
    try:
        meter = subprocess.Popen(
            [*command, f"--loop-ms={_POWER_MS}"], stdout=subprocess.PIPE, text=True
        )
    except OSError:
        meter = None
    started = time.perf_counter()
    times = 0
    while time.perf_counter() - started < _POWER_S:
        work()
        times += 1
    seconds = (time.perf_counter() - started) / times
    if meter is None:
        return None, seconds
    meter.terminate()
    told, _ = meter.communicate()
    watts = []
    for line in told.split():
        try:
            watts.append(float(line))
        except ValueError:
            return None, seconds
    return (fmean(watts) if watts else None), seconds


def _gpu_names() -> list[str]:
    """Return a note on the GPU and its driver, if nvidia-smi reports them."""
    command = [*_NVIDIA_SMI, "--query-gpu=name,driver_version", "--format=csv,noheader"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    except (OSError, subprocess.SubprocessError):
        return []
    return [f"GPU and driver: {line}." for line in done.stdout.strip().splitlines()]
