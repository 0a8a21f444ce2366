"""The table of replans in flight, from the results of :mod:`bench.replan`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from statistics import mean, median
from typing import Any

import numpy as np

from bench.report import Report
from bench.scenarios import missing


Result = dict[str, Any]
#: Results by scenario.
Flights = dict[int, Result]

#: The row of the chip's model.
MODEL = "ga-chip, model:"

# Place of the time of chip and line in an attempt.
_CHIP_MS = 1
# Limits of the answers: chip and line, all together, and the length of the aircraft.
_PROMPT_MS, _IN_ALL_MS, _LENGTH_M = 3.0, (10.0, 20.0), 1.5
# Maximum number of flights that an answer names.
_MOST_NAMED = 12


def report(results: dict[str, Flights], yardstick: Flights, count: int) -> Report:
    """Return the table of rows by name; its data has the flights that should have survived."""
    table = Report(
        f"Replans in flight: {count} scenarios",
        (
            "planner",
            "flown",
            "survived, of those that can be",
            "new path after ms",
            "metres flown",
            "chip and line ms",
            "where there is a path at once",
            "chip and line ms there",
            "new path there after ms",
            "first attempt",
            "host's share, measured ms",
            "waited on a circle",
            "least clearance, m",
            "least zone distance, m",
            "mean F of new paths",
        ),
        notes=[
            "Figures with slashes: p50 / p95 / p99 / maximum. Time and metres from the change to "
            "the new path at the autopilot, for changes that need one, where the row's planner "
            "found it and the aircraft did not wait on a circle. Chip and line: all attempts "
            "together. Where there is a path at once: changes for which the first attempt, or an "
            "ample search from the same start, finds one, with or without waiting circles and no "
            "board lost. Host's share: median, on this machine. Survived: touched neither ground "
            "nor zone, left a zone over the aircraft within 1.1 times the shortest way out, and "
            "arrived where the yardstick arrives. A flight that arrives can be survived, and so "
            "can one that the yardstick survives; it flies one in ten and all that do not arrive.",
            *missing(),
        ],
    )
    failures = []
    for name, flights in results.items():
        if not flights:
            continue
        table.rows.append((name, *_cells(flights, yardstick)))
        failures += [
            {"row": name, "scenario": number, **flight}
            for number, flight in flights.items()
            if not _survives(flight, yardstick.get(number)) and _can(flight, yardstick.get(number))
        ]
    table.data["failures"] = failures
    if results.get(MODEL):
        table.further = [_answers(results[MODEL], yardstick)]
    return table


def _answers(flights: Flights, yardstick: Flights) -> Report:
    """Return counts from the flights with the chip's model, and the numbers of exceptions."""
    changes = [
        (number, change)
        for number, flight in flights.items()
        for change in flight.get("changes", ())
        if change["needed"]
    ]
    prompt = [(number, change) for number, change in changes if _is_prompt(change)]
    at_once = [(number, change) for number, change in changes if _is_possible(change)]
    ready = {number: flight["ready"] for number, flight in flights.items() if "ready" in flight}
    lost = [number for number, flight in flights.items() if not flight["alive"]]
    shares = [flight["share"] for flight in flights.values() if "share" in flight]
    answers: list[tuple[str, str, Sequence[int]]] = [
        (
            "survived",
            f"{len(flights) - len(lost)} of {len(flights)}; arrived: "
            f"{sum(map(arrived, flights.values()))}",
            lost,
        ),
        (
            "not survived, but by the yardstick",
            str(sum(yardstick.get(number, {}).get("alive", False) for number in lost)),
            [number for number in lost if yardstick.get(number, {}).get("alive")],
        ),
        (
            "minimum share of the required clearance kept",
            f"{min(shares):.2f}" if shares else "-",
            (),
        ),
        _within("new paths by chip and line", prompt, _chip_ms, _PROMPT_MS, "ms"),
        *(
            _within("paths in all, where there is one at once", at_once, _active_ms, most, "ms")
            for most in _IN_ALL_MS
        ),
        _within("metres flown until a new path", prompt, lambda c: c["flown_m"], _LENGTH_M, "m"),
        (
            "flights in which each search for a circle found one",
            f"{sum(share == 1 for share in ready.values())} of {len(ready)}",
            (),
        ),
    ]
    table = Report(
        f"Answers from the flights of {MODEL}",
        ("question", "answer", "exceptions"),
        notes=[f"Exceptions: numbers of flights, {_MOST_NAMED} at most."],
    )
    for question, answer, exceptions in answers:
        named = [str(number) for number in sorted(set(exceptions))]
        cut = [*named[:_MOST_NAMED], "..."] if len(named) > _MOST_NAMED else named
        table.rows.append((question, answer, ", ".join(cut) or "-"))
    return table


def _within(
    question: str,
    changes: Sequence[tuple[int, Result]],
    measure: Callable[[Result], float],
    most: float,
    unit: str,
) -> tuple[str, str, Sequence[int]]:
    """Return how many changes have a measure of at most ``most``, and the flights of the rest."""
    later = [number for number, change in changes if not measure(change) <= most]
    kept = len(changes) - len(later)
    share = 100 * kept / max(len(changes), 1)
    answer = f"{kept} of {len(changes)} ({share:.1f} %)"
    return f"{question}: at most {most:g} {unit}", answer, later


def arrived(result: Result) -> bool:
    """Return whether a flight has survived and arrived at its goal."""
    return bool(result["alive"]) and result["ended"] == "arrived"


def _can(result: Result, yardstick: Result | None) -> bool:
    """Return whether a flight can be survived."""
    return arrived(result) or (yardstick is not None and yardstick["alive"])


def _survives(result: Result, yardstick: Result | None) -> bool:
    if not result["alive"]:
        return False
    return yardstick is None or not arrived(yardstick) or arrived(result)


def _cells(results: Flights, yardstick: Flights) -> tuple[object, ...]:
    possible = [number for number in results if _can(results[number], yardstick.get(number))]
    survived = [number for number in possible if _survives(results[number], yardstick.get(number))]
    told = [result for result in results.values() if "error" not in result]
    changes = [change for result in told for change in result["changes"] if change["needed"]]
    prompt = [change for change in changes if _is_prompt(change)]
    fitness = [change["fitness"] for change in changes if change["fitness"] is not None]
    chip = [_chip_ms(change) for change in prompt]
    at_once = [change for change in changes if _is_possible(change)]
    once = sum(len(change["attempts"]) == 1 for change in prompt)
    host = [change["measured_ms"] for change in prompt if change["measured_ms"] is not None]
    zones = [result["zone"] for result in told if result["zone"] is not None]
    return (
        len(results),
        f"{len(survived)} of {len(possible)} ({100 * len(survived) / max(len(possible), 1):.1f} %)",
        _spread([change["active_ms"] for change in prompt], 1),
        _spread([change["flown_m"] for change in prompt], 2),
        _spread(chip, 2) if any(chip) else "-",
        f"{len(at_once)} of {len(changes)}",
        _spread([_chip_ms(change) for change in at_once], 2) if any(chip) else "-",
        _spread([_active_ms(change) for change in at_once], 1),
        f"{once} of {len(prompt)}",
        f"{median(host):.1f}" if host else "-",
        f"{sum(change['held'] for change in changes)} of {len(changes)}",
        f"{min(result['clearance'] for result in told):.1f}" if told else "-",
        f"{min(zones):.1f}" if zones else "-",
        f"{mean(fitness):.4f}" if fitness else "-",
    )


def _is_prompt(change: Result) -> bool:
    """Return whether the flight's first planner found a path before a holding circle was needed."""
    planners = {each[0] for each in change["attempts"]}
    return change["active_ms"] is not None and not change["held"] and len(planners) == 1


def _chip_ms(change: Result) -> float:
    """Return the time of chip and line over all attempts; infinite if there never was a path."""
    if change["active_ms"] is None:
        return math.inf
    return float(sum(each[_CHIP_MS] for each in change["attempts"]))


def _is_possible(change: Result) -> bool:
    """Return whether a path exists immediately and the board that would find it is not lost."""
    return bool(change["at_once"]) and len({each[0] for each in change["attempts"]}) == 1


def _active_ms(change: Result) -> float:
    """Return the time until the new path was available; infinite if it never was."""
    return math.inf if change["active_ms"] is None else float(change["active_ms"])


def _spread(values: Sequence[float], digits: int) -> str:
    if not values:
        return "-"
    # Without interpolation, because some values may be infinite.
    parts = (*np.percentile(values, (50, 95, 99), method="inverted_cdf"), max(values))
    return " / ".join("never" if math.isinf(value) else f"{value:.{digits}f}" for value in parts)
