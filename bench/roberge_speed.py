"""Run time of the flower pollination algorithm: figures 9 and 10 of *roberge*."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from statistics import median
from typing import Any

from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import problem_at_one_cell
from host.errors import InputError
from host.evaluation import Evaluator
from host.planners import make
from host.planners.base import Options, Result


__all__ = ["run"]

MAP = "canyon"
#: Table 3.
ITERATIONS, POPULATION = 500, 512
#: Numbers of solutions, for all cores and the GPU.
SOLUTIONS = (64, 128, 256, 512, 1024, 2048)
_REPEATS = 3
# Not an engine: all threads with every candidate evaluated in full, as in the paper.
_IN_FULL = "all in full"

#: Section 5.3: engine, threads, solutions, seconds. 36 threads ran 9.6 times as fast as one.
PAPER = (
    ("paper: Xeon W-2195, 1 thread", 1, 512, 78.4),
    ("paper: Xeon W-2195, 18 cores", 36, 512, 8.1),
    ("paper: RTX A6000", "-", 512, 1.14),
)


def run(
    options: BenchOptions,
    *,
    iterations: int = ITERATIONS,
    population: int = POPULATION,
    solutions: Sequence[int] = SOLUTIONS,
) -> Report:
    """Time fpa-2opt by threads and by solutions, on each available engine."""
    del options
    report = Report(
        f"fpa-2opt on {MAP}: {iterations} iterations, 6 free waypoints, ds one cell, as paper",
        (
            "engine",
            "threads",
            "solutions",
            "seconds",
            "of iterations",
            "times as fast",
            "full evaluations/s",
            "cut short/s",
            "F",
        ),
    )
    cores = os.cpu_count() or 1
    cases: list[tuple[str, int, int]] = [
        ("sequential", 1, population),
        (_IN_FULL, 1, population),
        (_IN_FULL, cores, population),
    ]
    cases += [("cores", threads, population) for threads in range(1, cores + 1)]
    cases += [("cores", cores, count) for count in solutions if count != population]
    cases += [("gpu", 1, count) for count in sorted({*solutions, population})]
    base_s = 0.0
    left_out = ""
    for engine, threads, count in cases:
        try:
            results = [
                _plan(engine, threads, count, iterations, seed) for seed in range(_REPEATS + 1)
            ][1:]  # The first run compiles.
        except InputError as error:
            left_out = str(error)
            break
        seconds = median(result.seconds["total"] for result in results)
        base_s = base_s or seconds
        report.rows.append(
            (
                engine,
                "-" if engine == "gpu" else threads,
                count,
                seconds,
                median(result.seconds["iterations"] for result in results),
                base_s / seconds if count == population else "-",
                *(
                    median(_rate(result, what) for result in results)
                    for what in ("evaluations", "cut_short")
                ),
                median(result.evaluation.fitness for result in results),
            )
        )
        print(
            f"roberge-speed: {engine}, {threads} threads, {count} solutions done",
            file=sys.stderr,
            flush=True,
        )
    if cores > 1:
        together_s = _together(cores, population, iterations)
        report.rows.append(
            (
                "sequential, one a core",
                cores,
                population,
                together_s,
                "-",
                cores * base_s / together_s,
                "-",
                "-",
                "-",
            )
        )
    report.rows += [
        (name, threads, count, seconds, "-", PAPER[0][3] / seconds, "-", "-", "-")
        for name, threads, count, seconds in PAPER
    ]
    report.notes = [
        f"Median of {_REPEATS} seeds after one that compiles; seconds from the first path drawn to",
        "the reported path, checked at ds / 8. Times as fast: compared with the first row, and for",
        "the paper with its first row. One run a core: independent runs at the same time, which",
        "show the limit of the machine. The paper gives neither its number of waypoints nor its",
        "ds. Cut short: candidates whose evaluation stopped once they could not be better; the",
        'rows "all in full" evaluate these to the end, as the paper does.',
    ]
    if left_out:
        report.notes.append(f"No GPU was measured. {left_out}")
    return report


def _plan(engine: str, threads: int, population: int, iterations: int, seed: int) -> Result:
    evaluator = Evaluator(problem_at_one_cell(MAP), threads=threads)
    in_full = engine == _IN_FULL
    return make("fpa-2opt", engine="cores" if in_full else engine, give_up=not in_full).plan(
        evaluator, Options(generations=iterations, population=population, seed=seed)
    )


def _together(cores: int, population: int, iterations: int) -> float:
    """Return the median seconds of simultaneous sequential runs, one per core."""
    # Spawned: a process that has had threads must not be forked.
    with ProcessPoolExecutor(cores, mp_context=get_context("spawn")) as pool:
        timed = partial(_sequential_s, population, iterations)
        rounds = [max(pool.map(timed, [seed] * cores)) for seed in range(_REPEATS + 1)]
    return median(rounds[1:])


def _sequential_s(population: int, iterations: int, seed: int) -> float:
    return _plan("sequential", 1, population, iterations, seed).seconds["total"]


def _rate(result: Result, what: str) -> Any:
    return getattr(result, what) / result.seconds["iterations"]
