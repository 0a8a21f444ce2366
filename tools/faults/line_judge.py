"""Sessions with a board over a line with faults."""

from __future__ import annotations

from collections import Counter
from typing import Any

from pathgene.hdl.protocol import Command
from pathgene.hdl.protocol.codec import encode_frame
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link, RefusedError
from pathgene.host.errors import JobError
from tools.faults.case import Case, Extent
from tools.faults.chips import Board, chip_on_line
from tools.faults.judge import DifferentError, Judge, Verdict
from tools.faults.line import ChipOnLine, FaultyLine, VirtualClock, Way
from tools.faults.sessions import SESSIONS, Session
from tools.faults.tracing import counted_lines, signal_of, signalled


__all__ = ["LineJudge"]

#: Patience of a link, in seconds and attempts: for the model, which answers immediately, and for
#: the Verilog.
_PATIENCE = {Board.MODEL: (0.25, 12), Board.SIM: (0.03, 12)}
#: Packages of ``host`` whose lines Ctrl-C may meet.
_PACKAGES = ("device",)

Told = list[Any]


class _Comparison:
    """Compares the messages of a session with its messages without faults."""

    def __init__(self, told: Told) -> None:
        self._told, self._at = told, 0

    def __call__(self, value: Any) -> None:
        """Compare the next value."""
        if self._at == len(self._told) or value != self._told[self._at]:
            raise DifferentError(f"result {self._at} is another than without faults")
        self._at += 1

    def end(self) -> None:
        """Check that nothing is missing."""
        if self._at < len(self._told):
            raise DifferentError(f"{len(self._told) - self._at} results are missing")


class LineJudge(Judge):
    """Judges sessions with a kind of board; keeps their messages without faults.

    A session must end as it does without faults, with a documented error, or by Ctrl-C. Replies
    received before the end must equal the replies without faults. After that, another session does
    the whole work over a line without faults.
    """

    def __init__(self, board: Board) -> None:
        self.board = board
        self._kept: dict[tuple[str, int], tuple[Told, Extent]] = {}

    def extent(self, session: str, work: int) -> Extent:
        """Return how long a session is without faults."""
        return self._without_faults(session, work)[1]

    def run(self, case: Case, verdict: Verdict) -> None:
        """Run a session; see :class:`tools.faults.judge.Judge`."""
        with chip_on_line(self.board, case.session) as chip:
            self._run(case, chip, verdict)

    def _run(self, case: Case, chip: ChipOnLine, verdict: Verdict) -> None:
        told, _ = self._without_faults(case.session, case.work)
        for number in range(1, case.sessions_before + 1):
            chip.feed(encode_frame(bytes((number % 256, 255, Command.OPEN))))
        line, link = self._connect(chip, case)
        opened: Chip | None = None
        try:
            with signalled(case.signal_at, _PACKAGES):
                opened = Chip(link)
                _do(opened, case, told)
        except KeyboardInterrupt:
            verdict.outcome = "interrupted"
        except JobError as error:
            verdict.outcome = type(error).__name__
        verdict.faults.update(event.fault.value for event in line.happened)
        verdict.faults["clock jump"] += len(case.jumps)
        if case.signal_at is not None:
            verdict.faults[signal_of(case.signal_at).name] += 1
        if opened is not None and case.resumes and verdict.outcome != "done":
            line.heal()
            try:
                opened.reopen()
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
            with chip_on_line(self.board, name) as chip:
                line, link = self._connect(chip)
                with counted_lines(_PACKAGES) as lines, Chip(link) as opened:
                    _session(name)(opened, work, told.append)
            traffic = link.traffic
            sent = {Way.TO_BOARD: traffic.bytes_to_board, Way.FROM_BOARD: traffic.bytes_from_board}
            self._kept[name, work] = told, Extent(sent, line.clock.readings, lines[0])
        return self._kept[name, work]


def _session(name: str) -> Session:
    return SESSIONS[name.split(",")[0]]


def _do(chip: Chip, case: Case, told: Told) -> None:
    """Execute a session; a refusal is not a documented end, because all requests are valid."""
    comparison = _Comparison(told)
    try:
        _session(case.session)(chip, case.work, comparison)
    except RefusedError as error:
        raise DifferentError(f"the chip refused what was right: {error}") from None
    comparison.end()
