"""Cycles of a generation from the chip's counters, and bytes of the three link modes."""

from __future__ import annotations

import random

import numpy as np

from bench.allaire_table1 import GENERATIONS, PHASES
from bench.report import Options, Report
from bench.scenarios import EMBEDDED, problem
from pathgene.hdl.protocol.codes import LinkMode
from pathgene.host.device.boards import open_board
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import make
from pathgene.host.planners.base import Options as PlanOptions


# Names of the chip's counters.
_COUNTERS = {
    "selection_crossover": "crossover",
    "mutation": "mutation",
    "population_update": "update",
}
# The map's size does not affect the cycles of a generation, only the time to upload it.
_SMALL_MAP = "sim:?map_size=64"
_NO_MAP = "sim:?checker=none"
_PLAN_GENERATIONS = 300


def run(options: Options) -> Report:
    """Run 60 generations of full-length paths, then of a planner's path lengths, in every mode.

    This is repeated with a map of random altitudes to avoid, where every second new waypoint is in
    the ground.
    """
    report = Report(
        f"A generation on the simulated board, mean of {GENERATIONS}, cycles",
        (
            "unit",
            "paths of 16",
            "paths of 2 to 7",
            "paths of 16, ground avoided",
            "paths of 2 to 7, ground avoided",
            "paths of 2 to 7, no checker",
            "paper",
        ),
    )
    measured = [
        _measure(lengths, LinkMode.RANK, avoid_ground=avoid_ground)[0]
        for avoid_ground in (False, True)
        for lengths in ((16, 16), (2, 7))
    ]
    measured.append(_measure((2, 7), LinkMode.RANK, board=_NO_MAP)[0])
    for unit, phase in PHASES.items():
        cycles = (means[_COUNTERS[phase.key]] for means in measured)
        report.rows.append((unit, *cycles, phase.cycles))
    total = [sum(row[i] for row in report.rows) for i in range(1, len(report.columns))]
    report.rows.append(("together", *total))
    report.rows.append(("longest generation", *(means["longest"] for means in measured), "-"))
    report.notes.append(
        f"Avoiding the ground, {measured[2]['redrawn']:.2f} new waypoints of a generation of "
        f"paths of 16 were drawn again, and {measured[2]['left_out']:.2f} mutations left out."
    )

    sent = {mode: _measure((2, 7), mode)[1] for mode in LinkMode}
    whole = sum(sent[LinkMode.POPULATION])
    for mode, (to_board, from_board) in sent.items():
        report.notes.append(
            f"{mode.name.lower()} mode: {to_board:.0f} bytes to the board, {from_board:.0f} back "
            f"per generation, {100 * (to_board + from_board) / whole:.1f} % of population mode."
        )
    planned = {mode: _planned(mode) for mode in LinkMode}
    report.notes.append(
        f"Over a plan of {_PLAN_GENERATIONS} generations on {EMBEDDED}, start and reads included: "
        + ", ".join(
            f"{mode.name.lower()} mode {count / _PLAN_GENERATIONS:.0f} bytes per generation "
            f"({100 * count / planned[LinkMode.POPULATION]:.1f} %)"
            for mode, count in planned.items()
        )
        + "."
    )
    report.data = {
        "bytes": {mode.name.lower(): counts for mode, counts in sent.items()},
        "bytes of a plan": {mode.name.lower(): count for mode, count in planned.items()},
    }
    return report


def _planned(mode: LinkMode) -> int:
    """Return the bytes of a whole plan in both directions, which are the same on every board."""
    planner = make("ga-fpga", board="model:", link_mode=mode.name.lower())
    result = planner.plan(
        Evaluator(problem(EMBEDDED)), PlanOptions(seed=0, generations=_PLAN_GENERATIONS)
    )
    assert result.hardware is not None
    return sum(result.hardware["bytes"].values())


def _measure(
    lengths: tuple[int, int], mode: LinkMode, *, board: str = "sim:", avoid_ground: bool = False
) -> tuple[dict[str, float], tuple[float, float]]:
    """Return each counter's mean increase and the mean bytes in both directions, per generation."""
    rng = random.Random(1)
    with open_board(_SMALL_MAP if avoid_ground else board) as chip:
        config = chip.config
        if avoid_ground:
            shape = (config.map_size, config.map_size)
            chip.upload_map(np.random.default_rng(1).integers(0, config.blocked_altitude, shape))
        highest = config.map_size - 1
        limits = (highest, highest, config.blocked_altitude - 1)
        chip.start(1, limits, avoid_ground=avoid_ground)
        totals: dict[str, float] = {}
        to_board = from_board = 0
        longest = 0
        for _ in range(GENERATIONS):
            chip.load(
                [
                    [rng.getrandbits(config.waypoint_bits) for _ in range(rng.randint(*lengths))]
                    for _ in range(config.population)
                ]
            )
            order = rng.sample(range(config.population), config.population)
            before, traffic = chip.counters(), chip.link.traffic
            bytes_before = traffic.bytes_to_board, traffic.bytes_from_board
            chip.step(order, mode)
            to_board += traffic.bytes_to_board - bytes_before[0]
            from_board += traffic.bytes_from_board - bytes_before[1]
            after = chip.counters()
            for name in ("crossover", "mutation", "update", "redrawn", "left_out"):
                totals[name] = totals.get(name, 0) + after[name] - before[name]
            longest = max(longest, after["longest"])
        means = {name: total / GENERATIONS for name, total in totals.items()}
        means["longest"] = longest
        return means, (to_board / GENERATIONS, from_board / GENERATIONS)
