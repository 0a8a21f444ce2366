"""Runs a case, and holds what must be true of it."""

from __future__ import annotations

import contextlib
import signal
import sys
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any

from hdl.protocol import Command
from hdl.protocol.codec import encode_frame
from host.device.chip import Chip
from host.device.link import Link, RefusedError
from host.errors import JobError
from tools.faults.case import Case, Extent
from tools.faults.chips import Board, chip_on_line
from tools.faults.line import ChipOnLine, FaultyLine, HangError, VirtualClock, Way
from tools.faults.sessions import SESSIONS, Session


__all__ = ["Judge", "Verdict"]

#: Patience of a link, seconds and attempts: of the model, which answers at once; of the Verilog.
_PATIENCE = {Board.MODEL: (0.25, 12), Board.SIM: (0.03, 12)}
#: Seconds of this machine after which a session hangs, whatever the virtual time.
_LIMIT_S = 600
#: Code whose lines a signal may interrupt.
_DEVICE = str(Path(__file__).parents[2] / "host" / "device")

Told = list[Any]


class _DifferentError(Exception):
    """The host was told something that is not so."""


@dataclass
class Verdict:
    """What became of a case.

    Attributes
    ----------
    violation : str
        What was not kept; empty if all was.
    outcome : str
        How the session ended: ``done``, or the name of an error, and whether it was resumed.
    faults : Counter
        The faults that happened, by name.
    """

    violation: str = ""
    outcome: str = "done"
    faults: Counter[str] = field(default_factory=Counter)


class _Comparison:
    """Takes what a session tells, and compares it with what it tells without faults."""

    def __init__(self, told: Told) -> None:
        self._told, self._at = told, 0

    def __call__(self, value: Any) -> None:
        """Compare the next value."""
        if self._at == len(self._told) or value != self._told[self._at]:
            raise _DifferentError(f"result {self._at} is another than without faults")
        self._at += 1

    def end(self) -> None:
        """Check that nothing is missing."""
        if self._at < len(self._told):
            raise _DifferentError(f"{len(self._told) - self._at} results are missing")


class Judge:
    """Judges cases of a kind of board; keeps what sessions tell without faults.

    Parameters
    ----------
    board : Board
        The kind.
    """

    def __init__(self, board: Board) -> None:
        self.board = board
        self._kept: dict[tuple[str, int], tuple[Told, Extent]] = {}

    def extent(self, chip: str, work: int) -> Extent:
        """Return how long a session is without faults."""
        return self._without_faults(chip, work)[1]

    def judge(self, case: Case) -> Verdict:
        """Run a case.

        A session ends as it does without faults, or with a documented error, or by Ctrl-C. What it
        was told until then is what it is told without faults. After it another session does the
        whole work, over a line without faults.
        """
        verdict = Verdict()
        try:
            with chip_on_line(self.board, case.chip) as chip, _limited():
                self._run(case, chip, verdict)
        except HangError as error:
            verdict.violation = f"hangs: {error}"
        except _DifferentError as error:
            verdict.violation = str(error)
        except Exception as error:
            where = traceback.extract_tb(error.__traceback__)[-1]
            verdict.violation = (
                f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"
            )
        return verdict

    def _run(self, case: Case, chip: ChipOnLine, verdict: Verdict) -> None:
        told, _ = self._without_faults(case.chip, case.work)
        for number in range(1, case.sessions_before + 1):
            chip.feed(encode_frame(bytes((number % 256, 255, Command.OPEN))))
        line, link = self._connect(chip, case)
        opened: Chip | None = None
        try:
            with _signalled(case.signal_at):
                opened = Chip(link)
                _do(opened, case, told)
        except KeyboardInterrupt:
            verdict.outcome = "interrupted"
        except JobError as error:
            verdict.outcome = type(error).__name__
        verdict.faults.update(event.fault.value for event in line.happened)
        verdict.faults["clock jump"] += len(case.jumps)
        verdict.faults["signal"] += case.signal_at is not None
        if opened is not None and case.resumes and verdict.outcome != "done":
            line.heal()
            try:
                link.reopen()
                _do(opened, case, told)
                verdict.outcome += ", resumed"
            except JobError:
                verdict.outcome += ", not resumed"
        link.close()

        verdict.faults += Counter()  # Without zeros.
        _, link = self._connect(chip)
        with Chip(link) as later:
            _do(later, case, told)

    def _connect(self, chip: ChipOnLine, case: Case | None = None) -> tuple[FaultyLine, Link]:
        timeout_s, attempts = _PATIENCE[self.board]
        clock = VirtualClock(dict(case.jumps) if case else None)
        events = case.line if case else ()
        line = FaultyLine(chip, clock, events, patience_s=1.5 * attempts * timeout_s)
        return line, Link(line, timeout_s=timeout_s, attempts=attempts, clock=clock)

    def _without_faults(self, name: str, work: int) -> tuple[Told, Extent]:
        if (name, work) not in self._kept:
            told: Told = []
            with chip_on_line(self.board, name) as chip, _limited():
                line, link = self._connect(chip)
                with _counted_lines() as lines, Chip(link) as opened:
                    _session(name)(opened, work, told.append)
            traffic = link.traffic
            sent = {Way.TO_BOARD: traffic.bytes_to_board, Way.FROM_BOARD: traffic.bytes_from_board}
            self._kept[name, work] = told, Extent(sent, line.clock.readings, lines[0])
        return self._kept[name, work]


def _session(name: str) -> Session:
    return SESSIONS[name.split(",")[0]]


def _do(chip: Chip, case: Case, told: Told) -> None:
    """Do a session; a refusal is no documented end of it, since everything asked is right."""
    comparison = _Comparison(told)
    try:
        _session(case.chip)(chip, case.work, comparison)
    except RefusedError as error:
        raise _DifferentError(f"the chip refused what was right: {error}") from None
    comparison.end()


@contextlib.contextmanager
def _limited() -> Iterator[None]:
    """Raise :class:`HangError` if the block takes too long on this machine."""

    def end(_number: int, _frame: FrameType | None) -> None:
        raise HangError(f"no end after {_LIMIT_S} s of this machine")

    before = signal.signal(signal.SIGALRM, end)
    signal.alarm(_LIMIT_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@contextlib.contextmanager
def _traced(on_line: Callable[[], None]) -> Iterator[None]:
    """Call ``on_line`` before each line of the host's code for devices."""

    def trace(frame: FrameType, event: str, _argument: Any) -> Any:
        if event == "call" and not frame.f_code.co_filename.startswith(_DEVICE):
            return None
        if event == "line":
            on_line()
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        yield
    finally:
        sys.settrace(before)


@contextlib.contextmanager
def _signalled(at: int | None) -> Iterator[None]:
    """Raise KeyboardInterrupt, as Ctrl-C does, at the so many-th line in the block."""
    if at is None:
        yield
        return
    left = iter(range(at, -1, -1))

    def count() -> None:
        if next(left, None) == 0:
            raise KeyboardInterrupt

    with _traced(count):
        yield


@contextlib.contextmanager
def _counted_lines() -> Iterator[list[int]]:
    """Count the lines in the block; the list has their number at its end."""
    counted = [0]

    def count() -> None:
        counted[0] += 1

    with _traced(count):
        yield counted
