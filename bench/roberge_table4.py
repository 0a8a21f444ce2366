"""Flower pollination with and without 2-opt: table 4 of *roberge*, also at equal work."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Any

import numpy as np
from scipy import stats

from bench.campaign import measure
from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import TABLE_4, missing, names_of, problem_at_one_cell
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import make
from pathgene.host.planners.base import Options


#: Table 3.
ITERATIONS, POPULATION = 500, 512

#: Table 4 of the paper: length m, mean altitude m, fuel N, fitness and its deviation, without and
#: with 2-opt. Its starts, goals and zones are not published, so the maps here differ.
PAPER = {
    "canyon": ((8418, 119.3, 0.127, 1.295, 0.021), (7320, 86.6, 0.117, 1.348, 0.019)),
    "river": ((6559, 72.2, 0.099, 1.363, 0.025), (6126, 50.0, 0.090, 1.420, 0.018)),
    "Afghanistan": ((52874, 4236.2, 1.003, 1.451, 0.024), (52737, 4049.6, 0.992, 1.461, 0.010)),
    "Russia": ((34031, 445.6, 0.489, 1.346, 0.026), (33386, 322.0, 0.477, 1.395, 0.017)),
}

_TERMS = ("length_m", "mean_altitude_m", "fuel_N", "fitness")
_WAYS = ("fpa", "fpa, equal evaluations", "fpa-2opt")

Trial = dict[str, float]


def run(
    options: BenchOptions, *, iterations: int = ITERATIONS, population: int = POPULATION
) -> Report:
    """Run all trials of every available map."""
    report = Report(
        f"Table 4 of roberge: {options.trials} trials, {iterations} iterations, {population} "
        f"solutions, paper mode",
        (
            "map",
            "way",
            "candidates",
            "feasible",
            "length m",
            "mean altitude m",
            "fuel N",
            "mean F",
            "std F",
            "p of F against fpa-2opt",
        ),
    )
    runs: dict[str, dict[str, list[Trial]]] = {}
    for name in names_of(TABLE_4):
        trials = _trials(name, options.trials, iterations, population)
        hybrid = [trial["fitness"] for trial in trials["fpa-2opt"]]
        for way in _WAYS:
            report.rows.append(_row(name, way, trials[way], hybrid))
        runs[name] = trials
    for name, ways in PAPER.items():
        for way, (length, altitude, fuel, mean, deviation) in zip(
            ("fpa", "fpa-2opt"), ways, strict=True
        ):
            report.rows.append(
                (
                    f"paper: {name}",
                    way,
                    "-",
                    "-",
                    length,
                    altitude,
                    fuel,
                    mean,
                    deviation,
                    "0.00" if way == "fpa" else "-",
                )
            )
    report.notes = [
        "Means over the paths reported, infeasible ones included; ds is one cell, 6 free",
        "waypoints; maps, zones, starts and goals are from bench/scenarios.py: the paper's are",
        "not published, and its rows show the direction and the range. p: Welch's t-test,",
        "two-sided. Equal evaluations: fpa with so many iterations that it makes as many",
        "candidates as fpa-2opt; those given up early, because they could not be better, count on",
        "both sides.",
        *missing(TABLE_4),
        _verdict(runs),
    ]
    report.data = {"runs": runs, "paper": PAPER}
    return report


def _trials(name: str, count: int, iterations: int, population: int) -> dict[str, list[Trial]]:
    """Return all trials on a map, by variant."""
    seeds = range(count)

    def plan(way: str, planner: str, lengths: Sequence[int]) -> list[Trial]:
        return measure(
            "roberge-table4",
            [
                (name, planner, seed, length, population)
                for seed, length in zip(seeds, lengths, strict=True)
            ],
            _trial,
            name=lambda _: f"{name}, {way}",
            # A process that has had threads must not be forked.
            spawned=True,
        )

    hybrid = plan("fpa-2opt", "fpa-2opt", [iterations] * count)
    # After the first population, an iteration without 2-opt has one candidate per solution.
    longer = [ceil(trial["candidates"] / population) - 1 for trial in hybrid]
    return {
        "fpa": plan("fpa", "fpa", [iterations] * count),
        "fpa, equal evaluations": plan("fpa, equal evaluations", "fpa", longer),
        "fpa-2opt": hybrid,
    }


def _trial(name: str, planner: str, seed: int, iterations: int, population: int) -> Trial:
    evaluator = Evaluator(problem_at_one_cell(name), threads=1)
    result = make(planner, engine="sequential").plan(
        evaluator, Options(generations=iterations, population=population, seed=seed)
    )
    return {
        "seed": seed,
        **{term: getattr(result.evaluation, term) for term in _TERMS},
        "feasible": result.evaluation.feasible,
        "iterations": result.generations,
        "evaluations": result.evaluations,
        "cut_short": result.cut_short,
        "candidates": result.evaluations + result.cut_short,
        "seconds": result.seconds["total"],
    }


def _row(name: str, way: str, trials: list[Trial], hybrid: list[float]) -> Sequence[Any]:
    fitness = [trial["fitness"] for trial in trials]
    return (
        name,
        way,
        float(np.mean([trial["candidates"] for trial in trials])),
        f"{sum(bool(trial['feasible']) for trial in trials)}/{len(trials)}",
        *(float(np.mean([trial[term] for trial in trials])) for term in _TERMS),
        float(np.std(fitness, ddof=1)) if len(fitness) > 1 else 0.0,
        "-" if way == "fpa-2opt" else _p_value(hybrid, fitness),
    )


def _p_value(one: list[float], other: list[float]) -> float:
    """Return Welch's p, or 1 if there are too few trials."""
    if len(one) < 2:
        return 1.0
    return float(stats.ttest_ind(one, other, equal_var=False).pvalue)


def _verdict(runs: dict[str, dict[str, list[Trial]]]) -> str:
    """Return a note on the maps where 2-opt is better or worse with p < 0.05."""
    sentences = []
    for way in _WAYS[:2]:
        better = worse = 0
        for trials in runs.values():
            hybrid, other = (
                [trial["fitness"] for trial in trials[name]] for name in ("fpa-2opt", way)
            )
            if _p_value(hybrid, other) < 0.05:
                better += np.mean(hybrid) > np.mean(other)
                worse += np.mean(hybrid) < np.mean(other)
        sentences.append(
            f"Against {way}, 2-opt is better on {better} and worse on {worse} of "
            f"{len(runs)} maps with p < 0.05."
        )
    return " ".join(sentences)
