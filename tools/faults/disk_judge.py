"""The judge of sessions that write files, on a disk with faults that may lose its power."""

from __future__ import annotations

import errno
import random
from functools import cache
from pathlib import Path

from pathgene.host.errors import InputError, JobError
from pathgene.host.files.disk import using
from tools.faults.case import Case, DiskExtent, DiskFault
from tools.faults.disk import SLOW, FaultyDisk, Killed
from tools.faults.disk_sessions import DISK_SESSIONS, DiskSession, Ending, in_folder
from tools.faults.judge import DifferentError, Judge, Verdict
from tools.faults.platter import Platter
from tools.faults.tracing import counted_lines, signal_of, signalled


# Ends of an attempt after which its folder may have files of several runs.
_BROKEN = ("killed", "not put back")


class DiskJudge(Judge):
    """Judges sessions that write files.

    Each attempt must end as it does without faults, with a documented error, by Ctrl-C, or because
    its process is killed, by itself or with the power of the disk. The bytes on the disk must then
    equal the bytes of a session without faults, or be a mixture that the product refuses. The last
    attempt, without faults, continues from there and must end as if nothing had happened.
    """

    def extent(self, session: str, work: int) -> DiskExtent:
        """Return how long a session is without faults."""
        return _extent(session)

    def run(self, case: Case, verdict: Verdict) -> None:
        """Run a session; see :class:`tools.faults.judge.Judge`."""
        session = _session(case.session)
        ends: list[str] = []
        oldest, refused = 0, False
        with in_folder() as folder:
            session.prepare(folder)
            platter = Platter(folder)
            # A signal may also end the attempt without faults.
            for number, fault in enumerate((*case.disk, None, None), 1):
                disk = _disk(fault, case.seed, platter)
                is_first = number == 1
                signal_at = case.signal_at if is_first else None
                death = case.death_after if is_first else None
                end = _attempt(session, folder, number, disk, signal_at, death)
                if fault is not None and (disk.failed or disk.slowed):
                    if fault.kill:
                        end = "killed"  # A signal that was held back until now.
                    verdict.faults[f"disk: {_name(fault)}"] += 1
                elif fault is not None and fault.power:
                    verdict.faults["disk: power lost at the end"] += 1
                if _loses(fault):
                    platter.lose(random.Random(f"{case.seed} {number}"))
                if end == "done" and _refused(disk, "sync"):
                    raise DifferentError("the disk refused to store a file, and nothing tells")
                synced = [call for call in disk.calls if call.startswith("sync_directory")]
                refused = _refused(disk, "sync_directory") or (refused and not synced)
                session.check(
                    folder,
                    Ending(
                        number,
                        oldest,
                        is_whole=end == "done",
                        is_interrupted=end == "interrupted",
                        is_refused=disk.failed,
                        is_broken=end in _BROKEN or (end != "done" and _loses(fault)),
                        is_kept=end == "not put back",
                        is_forgotten=refused and _loses(fault),
                    ),
                )
                if end == "done" and not refused:
                    oldest = number
                ends.append(end)
            if any(file.name[0] == "." for file in folder.iterdir()):
                raise DifferentError("a temporary file is left")
        if case.signal_at is not None:
            verdict.faults[signal_of(case.signal_at).name] += 1
        if case.death_after is not None:
            verdict.faults["worker killed"] += 1
        verdict.outcome = ends[0]


def _disk(fault: DiskFault | None, seed: int, platter: Platter) -> FaultyDisk:
    if fault is None:
        return FaultyDisk(platter=platter)
    return FaultyDisk(
        fault.at,
        error=fault.error,
        lasting=fault.lasting,
        kill=fault.kill,
        calls=fault.calls,
        seed=seed,
        platter=platter,
    )


def _loses(fault: DiskFault | None) -> bool:
    return fault is not None and fault.power


def _refused(disk: FaultyDisk, *calls: str) -> bool:
    """Return whether the disk has refused one of some kinds of calls."""
    return any(call.split()[0] in calls for call in disk.refused)


def _name(fault: DiskFault) -> str:
    if fault.kill:
        return "power lost" if fault.power else "killed"
    return "slow" if fault.error == SLOW else errno.errorcode[fault.error]


def _attempt(
    session: DiskSession,
    folder: Path,
    number: int,
    disk: FaultyDisk,
    signal_at: int | None,
    death: int | None,
) -> str:
    """Execute an attempt; return how it ended."""
    try:
        with using(disk), signalled(signal_at, session.packages) as sent:
            session.attempt(folder, number, death)
    except Killed:
        return "killed"
    except KeyboardInterrupt as error:
        # Held back until the files were abandoned.
        return _end(str(error.__context__), "interrupted", disk)
    except (InputError, JobError) as error:
        if not disk.failed:
            raise
        return _end(str(error), type(error).__name__, disk)
    if sent:
        raise DifferentError(f"{sent[0].name} had no effect")
    return "done"


def _end(text: str, name: str, disk: FaultyDisk) -> str:
    """Return the end of an attempt; only a disk that refuses twice may leave files."""
    if "put back" not in text:
        return name
    if len(disk.refused) < 2 or not _refused(disk, "rename", "unlink"):
        raise DifferentError(f"the disk would have put every file back, but: {text}")
    return "not put back"


@cache
def _session(name: str) -> DiskSession:
    session = DISK_SESSIONS[name]()
    session.learn()
    return session


@cache
def _extent(name: str) -> DiskExtent:
    session, disk = _session(name), FaultyDisk()
    with in_folder() as folder:
        session.prepare(folder)
        with using(disk), counted_lines(session.packages) as lines:
            session.attempt(folder, 1, None)
    return DiskExtent(len(disk.calls), lines[0])
