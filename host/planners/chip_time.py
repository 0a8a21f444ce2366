"""Time that a plan takes a real chip and its line, from what a run on any board has counted.

A look at a run that goes on costs bytes, and how often the host looks depends on the clock of the
machine. So the looks of a real board are computed: the same counts give the same time everywhere.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from host.planners.problem_on_chip import LINE_BITS, pause_s


__all__ = ["BAUD", "ChipTime", "Look", "chip_time", "line_s"]

#: The line: bits a second, 33 cycles of a clock of 100 MHz each.
BAUD = 3_000_000


def line_s(count: float) -> float:
    """Return the seconds of bytes on the line."""
    return count * LINE_BITS / BAUD


@dataclass(frozen=True)
class Look:
    """A STATUS during a run: seconds of its request on the line, and of the reply."""

    asked_s: float
    told_s: float

    @staticmethod
    def of(to_board: int, from_board: int) -> Look:
        """Return the look of so many bytes."""
        return Look(line_s(to_board), line_s(from_board))

    def until_over(self, run_s: float, limit_s: float, first_s: float = 0.0) -> float:
        """Return the seconds from the beginning of a run until a look has told that it is over.

        The host looks as :class:`host.planners.problem_on_chip.ProblemOnChip` does, from
        ``first_s`` on.
        """
        passed_s, is_over = first_s, False
        while not is_over:
            is_over = passed_s + self.asked_s >= run_s
            passed_s += self.asked_s + self.told_s
            if not is_over:
                passed_s += pause_s(limit_s, passed_s, self.asked_s + self.told_s)
        return passed_s


@dataclass(frozen=True)
class ChipTime:
    """Time of a plan.

    Parameters
    ----------
    whole_s : float
        Seconds of drawing, runs, looks and bytes on the line, one after the other. Answers to the
        commands that begin a run are left out: they come while later commands are sent, and the
        last while the run goes on.
    exchanges : int
        Times that the host waits for replies; all looks at a run count as one.
    """

    whole_s: float
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
    to_board, from_board = (hardware["look_bytes"][way] for way in ("to_board", "from_board"))
    look = Look.of(to_board, from_board)
    whole_s = hardware["drawing_cycles"] / clock_hz
    for done in counted:
        look_bytes = done["looks"] * (to_board + from_board)
        whole_s += line_s(sum(done["bytes"].values()) - done["answer_bytes"] - look_bytes)
        run_s, limit_s = done["cycles"] / clock_hz, done["limit"] / clock_hz
        # The first look waits for the answer to RUN.
        answered_s = line_s(done["answer_bytes"] / done["answers"])
        whole_s += look.until_over(run_s, limit_s, answered_s)
    looks = sum(done["looks"] for done in hardware["runs"])
    return ChipTime(whole_s, hardware["exchanges"] - looks + len(counted))
