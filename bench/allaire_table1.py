"""Table 1 of *allaire-2008*, repeated: the genetic algorithm on the PC alone and on the chip."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import mean
from typing import Any

from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import LARGE, problem
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import make
from pathgene.host.planners.base import Options, Result


GENERATIONS = 60
#: Clock of the paper's FPGA. The PC was a Pentium 4 of 2.8 GHz.
CLOCK_HZ = 100e6


@dataclass(frozen=True)
class Phase:
    """A phase of the genetic algorithm that the paper moved to the FPGA."""

    #: Name of its time in a result of ``ga-pc``, and of its cycles in a result of ``ga-fpga``.
    key: str
    pc_s: float
    fpga_s: float

    @property
    def cycles(self) -> float:
        """Return the cycles of a generation on the paper's FPGA."""
        return self.fpga_s * CLOCK_HZ / GENERATIONS


PHASES = {
    "selection and crossover": Phase("selection_crossover", 94e-3, 8.85e-6),
    "mutation": Phase("mutation", 2e-3, 18e-6),
    "population update": Phase("population_update", 30e-3, 600e-9),
}


_MOST_SEEDS = 10
# Evaluation including its waits: seconds on the paper's PC, alone and with sorted populations.
_PAPER_EVALUATION_S = 60.0, 50.0


def run(options: BenchOptions, *, generations: int = GENERATIONS, board: str = "sim:") -> Report:
    """Run both planners for ``generations``, by default as in the paper, on its kind of map."""
    report = Report(
        f"{generations} generations on the PC and on the chip, per phase, paper mode",
        (
            "phase",
            "paper: PC, ms",
            "paper: FPGA, microseconds",
            "paper: times faster",
            "ga-pc, ms",
            "ga-fpga, cycles",
            "ga-fpga, microseconds",
            "times faster",
        ),
    )
    seeds = range(min(options.seeds, _MOST_SEEDS))
    # On one core, like the paper's PC.
    evaluator = Evaluator(problem(LARGE), threads=1)
    _plan("ga-pc", evaluator, 0, 1)  # Compiles.
    pc = [_plan("ga-pc", evaluator, seed, generations) for seed in seeds]
    chip = [_plan("ga-fpga", evaluator, seed, generations, board=board) for seed in seeds]
    [clock_hz] = {_hardware(result)["clock_hz"] for result in chip}
    for name, phase in PHASES.items():
        pc_s = mean(result.seconds[phase.key] for result in pc)
        cycles = mean(_hardware(result)["cycles"][phase.key] for result in chip)
        chip_s = cycles / clock_hz
        report.rows.append(
            (
                name,
                1e3 * phase.pc_s,
                1e6 * phase.fpga_s,
                phase.pc_s / phase.fpga_s,
                1e3 * pc_s,
                cycles,
                1e6 * chip_s,
                pc_s / chip_s,
            )
        )
    pc_s, chip_s = (
        mean(result.seconds["evaluation"] + result.seconds.get("sort", 0.0) for result in results)
        for results in (pc, chip)
    )
    alone, sorted_s = _PAPER_EVALUATION_S
    report.rows.append(
        (
            "evaluation and sorting",
            1e3 * alone,
            1e6 * sorted_s,
            alone / sorted_s,
            1e3 * pc_s,
            "on the host",
            1e6 * chip_s,
            pc_s / chip_s,
        )
    )
    evaluations = [mean(result.evaluations for result in results) for results in (pc, chip)]
    report.notes = [
        f"Means of {len(seeds)} seeds on {LARGE} (80 x 80 km, 0 to 3500 m). Paper: a Pentium 4 of "
        f"2.8 GHz and a Virtex-II Pro at {CLOCK_HZ / 1e6:.0f} MHz.",
        "Here: one core of this machine, ga-pc in Python with NumPy; the chip's own counters on "
        f"the simulated board, at its nominal {clock_hz / 1e6:.0f} MHz (docs/boards.md has the "
        "routed clocks).",
        "Neither contains the link. The host evaluates in both, with compiled code: "
        f"{evaluations[0]:.0f} and {evaluations[1]:.0f} paths a run; for ga-fpga with "
        "waypoints to unpack, and with caches that the simulator has used in between.",
    ]
    return report


def _plan(planner: str, evaluator: Evaluator, seed: int, generations: int, **own: str) -> Result:
    options = Options(seed=seed, generations=generations)
    return make(planner, **own).plan(evaluator, options)


def _hardware(result: Result) -> dict[str, Any]:
    assert result.hardware is not None
    return result.hardware
