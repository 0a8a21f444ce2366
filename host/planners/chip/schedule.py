"""The runs of a plan on the chip: their schedule, and their time on a real chip and its line."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pathgene.hdl.config import LINE_BITS, Config
from pathgene.hdl.protocol.planner import BLOCKS, COARSE_BLOCKS
from pathgene.hdl.protocol.random_words import SEED_BITS
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.planners.chip.problem_on_chip import pause_s


__all__ = [
    "BAUD",
    "MOST_RUNS",
    "SURFACES",
    "UNGUIDED_RUNS",
    "ChipSchedule",
    "ChipTime",
    "Look",
    "blocks_of",
    "chip_time",
    "line_s",
]


#: Maximum number of runs from new seeds: if no path of a run is feasible, the next has other seeds
#: and the next surfaces.
MOST_RUNS = 8
#: Number of runs without a feasible path after which a guide is sought, and maximum number of runs
#: along it.
UNGUIDED_RUNS, _GUIDED_RUNS = 2, 3
#: Slopes of these surfaces.
SURFACES = RunOptions.slopes, (2, 5), (1, 8), (4, 0)
#: Maximum number of parts of a plan, and minimum time and generations of each: a shorter run gains
#: more by continuing than by new seeds.
_MOST_PARTS = 4
_PART_MS = 12
_PART_GENERATIONS = 1_600
#: Surfaces of the new seeds that are added to the population of the previous part, in rotation, and
#: the sixteenths of the time for which both islands exist.
_FURTHER_SLOPES = (0,), (3,)
_FURTHER_SHARE = 10
_UNLIMITED = (1 << 32) - 1
#: Cycles of a run from which the first populations may cost the time of routes over fine blocks.
_FINE_CYCLES = 300_000
#: Cycles of a run from which a finer map is worth its longer walks, and maximum number of parts
#: into which the sides of the cells of the terrain are divided.
_FINER_MAP_CYCLES, _MOST_PARTS_OF_CELLS = 1_000_000, 4


@dataclass(frozen=True, kw_only=True)
class ChipSchedule:
    """Options of all runs of a plan.

    A long plan is split into up to four equal parts. The first part is a run from new seeds, which
    is repeated with other seeds until a path is feasible. Each later run continues from the
    previous population, with an additional island of new seeds.

    Parameters
    ----------
    seed : int
        0..2**64 - 1. It determines the seeds of all runs.
    generations : int
        Generations of the whole plan, if one first run is enough.
    chip_ms : float, optional
        Maximum milliseconds of the plan by the chip's clock; None limits only the generations.
    """

    config: Config
    seed: int
    generations: int
    chip_ms: float | None = None

    @property
    def parts(self) -> int:
        """Parts of the plan, 1..4."""
        most = self.generations // _PART_GENERATIONS
        if self.chip_ms is not None:
            most = min(most, int(self.chip_ms // _PART_MS))
        return min(max(most, 1), _MOST_PARTS)

    @property
    def blocks(self) -> int:
        """Blocks along each edge of the map over which routes are found."""
        return blocks_of(self._cycles)

    @property
    def most_parts_of_cells(self) -> int:
        """Maximum number of parts into which the map may divide the sides of the cells."""
        return _MOST_PARTS_OF_CELLS if self._cycles >= _FINER_MAP_CYCLES else 1

    def first(self) -> list[RunOptions]:
        """Return the options of the runs from new seeds, in order, until one finds a path."""
        generations = self.generations // self.parts
        return [
            self._run(number, generations, slopes=SURFACES[number % len(SURFACES)])
            for number in range(MOST_RUNS)
        ]

    def guided(self, waypoints: int) -> list[RunOptions]:
        """Return the options of runs from new seeds along a guide, until one finds a path."""
        generations = self.generations // self.parts
        return [
            self._run(UNGUIDED_RUNS + number, generations, slopes=(0,), guided=waypoints)
            for number in range(_GUIDED_RUNS)
        ]

    def further(self) -> list[RunOptions]:
        """Return the options of the runs that follow a first run with a path."""
        each, rest = divmod(self.generations, self.parts)
        return [
            self._run(
                # Seeds that plans with nearby seeds do not use.
                part << 32,
                each + rest * (part == self.parts - 1),
                slopes=_FURTHER_SLOPES[(part - 1) % len(_FURTHER_SLOPES)],
                share=_FURTHER_SHARE,
                warm=True,
            )
            for part in range(1, self.parts)
        ]

    @property
    def _cycles(self) -> int:
        """Maximum cycles of each run."""
        if self.chip_ms is None:
            return _UNLIMITED
        whole = math.ceil(self.chip_ms * self.config.clock_hz / 1000)
        return min(-(-whole // self.parts), _UNLIMITED)

    def _run(
        self,
        seeds_on: int,
        generations: int,
        *,
        slopes: tuple[int, ...],
        share: int = RunOptions.share,
        warm: bool = False,
        guided: int = 0,
    ) -> RunOptions:
        return RunOptions(
            seed=(self.seed + seeds_on) % (1 << SEED_BITS),
            cycles=self._cycles,
            generations=min(generations, _UNLIMITED),
            give_up_rank=min(RunOptions.give_up_rank, self.config.population - 1),
            slopes=slopes,
            share=share,
            warm=warm,
            guided=guided,
        )


def blocks_of(cycles: int) -> int:
    """Return the blocks along each edge of the map for a run of ``cycles``: few in a short one."""
    return COARSE_BLOCKS if cycles < _FINE_CYCLES else BLOCKS


#: The line: bits per second, each of 33 cycles of a 100 MHz clock.
BAUD = 3_000_000


def line_s(count: int) -> float:
    """Return the seconds that bytes take on the line."""
    return count * LINE_BITS / BAUD


@dataclass(frozen=True)
class Look:
    """Seconds on the line of a BEST sent during a run, and of the refusals of it and of STATUS.

    STATUS follows BEST and arrives during the first refusal.
    """

    asked_s: float
    told_s: float

    def until_over(self, run_s: float, limit_s: float, first_s: float = 0.0) -> float:
        """Return the seconds from the beginning of a run until the first poll after its end.

        The host polls as :class:`~pathgene.host.planners.chip.problem_on_chip.ProblemOnChip` does,
        starting at ``first_s``.
        """
        passed_s = first_s
        while passed_s + self.asked_s < run_s:
            passed_s += self.asked_s + self.told_s
            passed_s += pause_s(limit_s, passed_s, self.asked_s + self.told_s)
        return passed_s + self.asked_s


@dataclass(frozen=True)
class ChipTime:
    """Time of a plan.

    Parameters
    ----------
    whole_s : float
        Seconds until the host has the paths of the last run: runs, polls and bytes on the line, in
        sequence. The chip draws zones while later commands arrive, so only the rest of the drawing
        counts. The answers to the commands that begin a run do not count: they arrive while later
        commands are sent, and the last one during the run.
    status_s : float
        Seconds on the line of the answer to STATUS, which follows the paths.
    exchanges : int
        Number of times that the host waits for an answer; all polls of a run count as one.
    """

    whole_s: float
    status_s: float
    exchanges: int


def chip_time(hardware: Mapping[str, Any], runs: int | None = None) -> ChipTime:
    """Return the time of a plan.

    Parameters
    ----------
    hardware : mapping
        ``hardware`` of the summary of a plan by ``ga-chip``.
    runs : int, optional
        Only the first runs count, as if the plan ended there; all by default.
    """
    clock_hz, counted = hardware["clock_hz"], hardware["runs"][:runs]
    whole_s = status_s = 0.0
    # All zones are drawn in the first run.
    drawing_s = hardware["drawing_cycles"] / clock_hz
    for done in counted:
        waits = done["waits"]
        whole_s += status_s + max(0.0, drawing_s - line_s(waits["after_zones"]))
        answer_s = line_s(waits["answer"])
        look = Look(line_s(waits["request"]), 2 * answer_s)
        # The first poll waits for the answer to RUN.
        over_s = look.until_over(done["cycles"] / clock_hz, done["limit"] / clock_hz, answer_s)
        whole_s += line_s(waits["commands"]) + over_s + line_s(waits["paths"])
        drawing_s, status_s = 0.0, line_s(waits["status"])
    return ChipTime(whole_s, status_s, sum(done["waits"]["exchanges"] for done in counted))
