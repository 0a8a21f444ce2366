"""Time of a plan on a real chip and its line, computed from the counts of a run on any board.

A poll of a run in progress costs bytes, and the number of polls depends on the clock of the host.
Therefore the polls of a real board are computed, so that the same counts give the same time
everywhere.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pathgene.host.planners.chip.problem_on_chip import LINE_BITS, pause_s


__all__ = ["BAUD", "ChipTime", "Look", "chip_time", "line_s"]

#: The line: bits per second, each of 33 cycles of a 100 MHz clock.
BAUD = 3_000_000


def line_s(count: int) -> float:
    """Return the seconds that bytes take on the line."""
    return count * LINE_BITS / BAUD


@dataclass(frozen=True)
class Look:
    """Seconds on the line of a BEST sent during a run, and of its refusal."""

    asked_s: float
    told_s: float

    def until_over(self, run_s: float, limit_s: float, first_s: float = 0.0) -> float:
        """Return the seconds from the beginning of a run until the first BEST after its end.

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
        Seconds on the line of the STATUS after the paths, and of its answer.
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
        look = Look(line_s(waits["request"]), answer_s)
        # The first poll waits for the answer to RUN.
        over_s = look.until_over(done["cycles"] / clock_hz, done["limit"] / clock_hz, answer_s)
        whole_s += line_s(waits["commands"]) + over_s + line_s(waits["paths"])
        drawing_s, status_s = 0.0, line_s(waits["status"])
    return ChipTime(whole_s, status_s, sum(done["waits"]["exchanges"] for done in counted))
