"""Cases: a session and its faults, drawn from a seed."""

from __future__ import annotations

import dataclasses
import errno
import json
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from tools.faults.chips import ANSWER_BYTES
from tools.faults.disk import SLOW
from tools.faults.line import LineEvent, LineFault, Way


#: Number of sessions of a chip, by the seed of their work; their results without faults are kept.
_WORKS = 8
#: Numbers of sessions opened before: a session's number is the last one plus 1, modulo 256, and a
#: chip begins at 0 after a reset.
_SESSIONS_BEFORE = (0, 0, 0, 1, 254, 255)
#: Bytes in each direction that open a session, about.
_OPENING_BYTES = {Way.TO_BOARD: 32, Way.FROM_BOARD: 64}
#: Faults at a place drawn from the whole session.
_ANYWHERE = tuple(
    fault
    for fault in LineFault
    if fault not in (LineFault.HOLD_FRAME, LineFault.LOSE_LONG, LineFault.GAP, LineFault.BABBLE)
)
#: Faults at a chosen command or at its answer, and faults within some bytes after it.
_AT_COMMANDS = (
    LineFault.GAP,
    LineFault.GAP,
    LineFault.GAP,
    LineFault.GAP,
    LineFault.STALL,
    LineFault.LOSE_FRAME,
    LineFault.REPEAT_FRAME,
    LineFault.DELAY_FRAME,
    LineFault.HOLD_FRAME,
    LineFault.RESET,
)
_SOON_AFTER = (LineFault.LOSE_FRAME, LineFault.FLIP, LineFault.REPEAT_FRAME, LineFault.DELAY_FRAME)
_SOON_BYTES = 200
#: Bytes of a short stretch with many faults.
_STRETCH_BYTES = 2_000


@dataclass(frozen=True)
class Extent:
    """Extent of a session without faults."""

    bytes: dict[Way, int]
    readings: int
    #: Number of executed lines of the host's code at which Ctrl-C may arrive.
    lines: int
    #: First bytes, to the board, of the commands whose number is 0 again.
    firsts: tuple[int, ...] = ()
    #: By the kind of the command, the first bytes of all such commands and of their answers.
    commands: tuple[tuple[tuple[int, int], ...], ...] = ()


@dataclass(frozen=True)
class DiskExtent:
    """Extent, without faults, of a session that writes files."""

    calls: int
    #: As in :class:`Extent`.
    lines: int


@dataclass(frozen=True)
class DiskFault:
    """A call of the disk that fails or is slow; see :class:`tools.faults.disk.FaultyDisk`."""

    #: Number of the call, from 1.
    at: int
    #: Number of the error; 0 if the call is slow.
    error: int
    #: Whether all later calls fail or are slow too, and whether the process is killed.
    lasting: bool
    kill: bool
    #: Number of calls after which a lasting fault is over; 0 for none.
    calls: int = 0
    #: Whether the power fails at the kill, or at the end of the attempt if it makes fewer calls.
    power: bool = False


@dataclass(frozen=True)
class Case:
    """A session with faults."""

    seed: int
    #: Key of :data:`tools.faults.chips.CHIPS` or :data:`tools.faults.disk_sessions.DISK_SESSIONS`.
    session: str
    work: int
    sessions_before: int = 0
    line: tuple[LineEvent, ...] = ()
    #: Readings of the processor's clock at which it jumps ahead, with the seconds.
    jumps: tuple[tuple[int, float], ...] = ()
    #: The line of the host's code, counted as they are executed, at which a signal arrives;
    #: :func:`tools.faults.tracing.signal_of` says which.
    signal_at: int | None = None
    #: After an error, the work continues with the same chip in a new link session.
    resumes: bool = False
    #: Fault of the disk in each attempt of a session that writes files; a further attempt without
    #: faults follows.
    disk: tuple[DiskFault, ...] = ()
    #: Number of results after which a worker process is killed in the first attempt.
    death_after: int | None = None

    def to_json(self) -> str:
        """Return the case as a line of JSON."""
        return json.dumps(dataclasses.asdict(self))

    @classmethod
    def from_json(cls, text: str) -> Case:
        """Return the case of a line of JSON."""
        fields: dict[str, Any] = json.loads(text)
        fields["line"] = tuple(
            LineEvent(**event | {"way": Way(event["way"]), "fault": LineFault(event["fault"])})
            for event in fields["line"]
        )
        fields["jumps"] = tuple((at, seconds) for at, seconds in fields["jumps"])
        fields["disk"] = tuple(DiskFault(**fault) for fault in fields["disk"])
        return cls(**fields)

    @property
    def faults(self) -> list[tuple[str, Any]]:
        """Every fault as field name and value; see :meth:`with_faults`."""
        found: list[tuple[str, Any]] = [("line", event) for event in self.line]
        found += [("jumps", jump) for jump in self.jumps]
        found += [("disk", fault) for fault in self.disk]
        for name in ("signal_at", "death_after"):
            if (value := getattr(self, name)) is not None:
                found.append((name, value))
        return found

    def with_faults(self, faults: list[tuple[str, Any]]) -> Case:
        """Return the case with only these faults."""

        def of(name: str) -> tuple[Any, ...]:
            return tuple(value for each, value in faults if each == name)

        return dataclasses.replace(
            self,
            line=of("line"),
            jumps=of("jumps"),
            disk=of("disk"),
            signal_at=next(iter(of("signal_at")), None),
            death_after=next(iter(of("death_after")), None),
        )


def draw(seed: int, session: str, extent_of: Callable[[int], Extent | DiskExtent]) -> Case:
    """Draw a case; ``extent_of`` returns the extent of the session from its ``work``."""
    rng = random.Random(seed)
    work = rng.randrange(_WORKS)
    extent = extent_of(work)
    if isinstance(extent, DiskExtent):
        return _disk_case(rng, seed, session, extent)
    line: list[LineEvent] = []
    kind = rng.random()
    if kind < 0.3:
        line += _noisy(rng, extent)
    if 0.2 < kind < 0.85:
        line += (_any_event(rng, extent) for _ in range(rng.choice((1, 1, 1, 2, 3, 6))))
    jumps: tuple[tuple[int, float], ...] = ()
    if rng.random() < 0.15:
        jumps = tuple(
            (rng.randrange(extent.readings), rng.choice((0.3, 5.0, 3600.0)))
            for _ in range(rng.choice((1, 1, 3)))
        )
    # Signals arrive even on a line without faults.
    signal_at = rng.randrange(extent.lines) if not line or rng.random() < 0.1 else None
    case = Case(
        seed=seed,
        session=session,
        work=work,
        sessions_before=rng.choice(_SESSIONS_BEFORE),
        line=tuple(sorted(line)),
        jumps=jumps,
        signal_at=signal_at,
        resumes=rng.random() < 0.5,
    )
    case = _with_rare_fault(random.Random(f"{seed} rare"), case, extent)
    return _at_a_command(random.Random(f"{seed} command"), case, extent)


def _with_rare_fault(rng: random.Random, case: Case, extent: Extent) -> Case:
    """Give some cases one more fault, which a random place would hardly ever be the right one for.

    One in 16 has a fault while the session is opened, one in 32 of the cases of a paper core a line
    that loses long answers, one in 32 a reset where the numbers of the commands begin again, in
    the session after 255, one in 32 a stretch with many faults, and one in 32 a board that repeats
    its latest frame again and again.
    """
    kind = rng.randrange(32)
    if kind < 2:
        way = rng.choice(list(Way))
        fault = rng.choice(_ANYWHERE) if kind else LineFault.HOLD_FRAME
        event = _event(rng, rng.randrange(_OPENING_BYTES[way]), way, fault)
        return dataclasses.replace(case, line=tuple(sorted((*case.line, event))))
    if kind == 2 and case.session in ANSWER_BYTES:
        at = rng.randrange(extent.bytes[Way.FROM_BOARD])
        event = LineEvent(at, Way.FROM_BOARD, LineFault.LOSE_LONG, ANSWER_BYTES[case.session])
        return dataclasses.replace(case, line=(event,), jumps=(), signal_at=None)
    if kind == 3 and extent.firsts:
        event = LineEvent(
            rng.choice(extent.firsts), Way.TO_BOARD, LineFault.RESET, rng.randrange(2_000)
        )
        return dataclasses.replace(case, sessions_before=255, line=(event,), signal_at=None)
    if kind == 4:
        return dataclasses.replace(case, line=tuple(sorted(_stretch(rng, extent))), signal_at=None)
    if kind == 5:
        at = rng.randrange(extent.bytes[Way.FROM_BOARD])
        event = LineEvent(at, Way.FROM_BOARD, LineFault.BABBLE, rng.choice((5, 50, 200)))
        return dataclasses.replace(case, line=(event,), jumps=(), signal_at=None)
    return case


def _stretch(rng: random.Random, extent: Extent) -> Iterator[LineEvent]:
    """Yield the faults of a stretch in which hardly any frame arrives."""
    rate = 10 ** rng.uniform(-2, -1)
    for way in Way:
        first = at = rng.randrange(extent.bytes[way])
        while (at := at + 1 + int(rng.expovariate(rate))) < first + _STRETCH_BYTES:
            yield LineEvent(at, way, LineFault.FLIP, rng.randrange(8))


def _at_a_command(rng: random.Random, case: Case, extent: Extent) -> Case:
    """Give half of the cases a fault at a command whose kind is drawn first.

    A command that a session sends once is chosen as often as one that it sends a thousand times. In
    half of these cases another fault follows soon. After an error, the work continues.
    """
    if not extent.commands or rng.random() < 0.5:
        return case
    way = rng.choice(list(Way))
    places = dict(zip(Way, rng.choice(rng.choice(extent.commands)), strict=True))
    line = [_event(rng, places[way] + rng.randrange(4), way, rng.choice(_AT_COMMANDS))]
    if rng.random() < 0.5:
        at = places[Way.TO_BOARD] + rng.randrange(_SOON_BYTES)
        line.append(_event(rng, at, Way.TO_BOARD, rng.choice(_SOON_AFTER)))
    return dataclasses.replace(
        case,
        line=tuple(sorted(line)),
        jumps=(),
        signal_at=None,
        resumes=True,
    )


def _disk_case(rng: random.Random, seed: int, session: str, extent: DiskExtent) -> Case:
    """Draw a case of a session that writes files."""
    attempts = rng.choice((0, 1, 1, 1, 2, 3))
    case = Case(
        seed=seed,
        session=session,
        work=0,
        disk=tuple(
            DiskFault(
                at=rng.randrange(1, extent.calls + 1),
                error=rng.choice((errno.ENOSPC, errno.ENOSPC, errno.EIO, errno.EROFS, SLOW)),
                lasting=rng.random() < 0.5,
                kill=(kill := rng.random() < 0.5),
                power=kill and rng.random() < 0.7,
            )
            for _ in range(attempts)
        ),
        signal_at=rng.randrange(extent.lines) if not attempts or rng.random() < 0.2 else None,
        death_after=rng.randrange(4) if session == "comparison" and rng.random() < 0.02 else None,
    )
    rare = random.Random(f"{seed} rare")
    if rare.randrange(16):
        return case
    # A disk that works again, so that the remains of a failure can be removed.
    at, calls = rare.randrange(1, extent.calls + 1), rare.randrange(2, 5)
    fault = DiskFault(at, errno.EIO, lasting=True, kill=False, calls=calls)
    return dataclasses.replace(case, disk=(fault,), signal_at=None)


def _noisy(rng: random.Random, extent: Extent) -> Iterator[LineEvent]:
    """Yield the faults of a constantly noisy line, including repeated frames."""
    rate = 10 ** rng.uniform(-4, -2.5)
    faults = rng.choice(
        (
            (LineFault.FLIP,),
            (LineFault.DROP,),
            (LineFault.DROP, LineFault.FLIP, LineFault.INSERT, LineFault.REPEAT),
            (LineFault.LOSE_FRAME, LineFault.REPEAT_FRAME, LineFault.MERGE, LineFault.DELAY_FRAME),
        )
    )
    for way in Way:
        at = 0
        while (at := at + 1 + int(rng.expovariate(rate))) < 2 * extent.bytes[way]:
            yield LineEvent(at, way, rng.choice(faults), rng.randrange(256))


def _any_event(rng: random.Random, extent: Extent) -> LineEvent:
    """Return a fault anywhere in the session."""
    way = rng.choice(list(Way))
    at = int(rng.random() * extent.bytes[way])
    if rng.random() < 0.2:
        at //= 50  # The beginning, during which the session is opened.
    return _event(rng, at, way, rng.choice(_ANYWHERE))


def _event(rng: random.Random, at: int, way: Way, fault: LineFault) -> LineEvent:
    if fault in (LineFault.FULL, LineFault.RESET):
        way = Way.TO_BOARD
    value = rng.randrange(256)
    if fault in (LineFault.STALL, LineFault.FULL):
        value = rng.choice((1, 20, 300, 3_000, 60_000))
    if fault is LineFault.GAP:
        value = rng.choice((300, 1_500, 1_500, 60_000, 60_000))
    if fault is LineFault.RESET:
        value = rng.randrange(2_000)
    if fault is LineFault.NOISE:
        value = rng.choice((1, 7, 64, 1_000))
    if fault is LineFault.HOLD_FRAME:
        value = rng.choice((3, 5, 9))
    return LineEvent(at, way, fault, value)


def shrunk(case: Case, fails: Callable[[Case], bool]) -> Case:
    """Return a case with a subset of the faults of ``case``, each of which is needed to fail.

    It leaves out halves, then quarters and so on, then single faults, until none can be removed.
    """
    faults = case.faults
    size = max(len(faults) // 2, 1)
    while faults:
        at, has_shrunk = 0, False
        while at < len(faults):
            fewer = faults[:at] + faults[at + size :]
            if fails(case.with_faults(fewer)):
                faults, has_shrunk = fewer, True
            else:
                at += size
        if size == 1 and not has_shrunk:
            break
        size = max(size // 2, 1)
    return case.with_faults(faults)
