"""The runs of a plan: runs from new seeds until one finds a path, then runs that continue it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.random_words import SEED_BITS
from pathgene.hdl.protocol.runs import RunOptions


__all__ = ["MOST_RUNS", "SURFACES", "ChipSchedule"]

#: Maximum number of runs from new seeds: if no path of a run is feasible, the next has other seeds
#: and the next surfaces.
MOST_RUNS = 8
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


@dataclass(frozen=True, kw_only=True)
class ChipSchedule:
    """Options of all runs of a plan.

    A long plan is split into up to four equal parts. The first part is a run from new seeds, which
    is repeated with other seeds until a path is feasible. Each later run continues from the
    previous population, with an additional island of new seeds.

    Parameters
    ----------
    config : Config
        The chip.
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

    def first(self) -> list[RunOptions]:
        """Return the options of the runs from new seeds, in order, until one finds a path."""
        generations = self.generations // self.parts
        return [
            self._run(number, generations, slopes=SURFACES[number % len(SURFACES)])
            for number in range(MOST_RUNS)
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

    def _run(
        self,
        seeds_on: int,
        generations: int,
        *,
        slopes: tuple[int, ...],
        share: int = RunOptions.share,
        warm: bool = False,
    ) -> RunOptions:
        cycles = _UNLIMITED
        if self.chip_ms is not None:
            whole = math.ceil(self.chip_ms * self.config.clock_hz / 1000)
            cycles = min(-(-whole // self.parts), _UNLIMITED)
        return RunOptions(
            seed=(self.seed + seeds_on) % (1 << SEED_BITS),
            cycles=cycles,
            generations=min(generations, _UNLIMITED),
            give_up_rank=min(RunOptions.give_up_rank, self.config.population - 1),
            slopes=slopes,
            share=share,
            warm=warm,
        )
