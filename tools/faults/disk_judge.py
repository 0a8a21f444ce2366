"""Sessions that write files, on a disk with faults."""

from __future__ import annotations

import errno
from functools import cache
from pathlib import Path

from pathgene.host.errors import InputError, JobError
from pathgene.host.files.disk import using
from tools.faults.case import Case, DiskExtent, DiskFault
from tools.faults.disk import SLOW, FaultyDisk, Killed
from tools.faults.disk_sessions import DISK_SESSIONS, DiskSession, in_folder
from tools.faults.judge import DifferentError, Judge, Verdict
from tools.faults.tracing import counted_lines, signal_of, signalled


__all__ = ["DiskJudge"]


class DiskJudge(Judge):
    """Judges sessions that write files.

    Each attempt must end as it does without faults, with a documented error, by Ctrl-C, or because
    its process is killed. The files on the disk must then be whole, or be marked as incomplete. The
    last attempt, without faults, continues from there and must end as if nothing had happened.
    """

    def extent(self, session: str, work: int) -> DiskExtent:
        """Return how long a session is without faults."""
        return _extent(session)

    def run(self, case: Case, verdict: Verdict) -> None:
        """Run a session; see :class:`tools.faults.judge.Judge`."""
        session = _session(case.session)
        ends: list[str] = []
        may_mix = False
        with in_folder() as folder:
            session.prepare(folder)
            # A signal may also end the attempt without faults.
            for number, fault in enumerate((*case.disk, None, None), 1):
                disk = FaultyDisk()
                if fault is not None:
                    disk = FaultyDisk(
                        fault.at,
                        error=fault.error,
                        lasting=fault.lasting,
                        kill=fault.kill,
                        seed=case.seed,
                    )
                is_first = number == 1
                signal_at = case.signal_at if is_first else None
                death = case.death_after if is_first else None
                end = _attempt(session, folder, number, disk, signal_at, death)
                if fault is not None and (disk.failed or disk.slowed):
                    if fault.kill:
                        end = "killed"  # A signal that was held back until now.
                    verdict.faults[f"disk: {_name(fault)}"] += 1
                if end != "done":
                    may_mix |= end in ("killed", "not put back")
                    session.check(folder, number, is_whole=False, may_mix=may_mix)
                else:
                    session.check(folder, number, is_whole=True, may_mix=False)
                    may_mix = False
                ends.append(end)
            if any(file.name[0] == "." for file in folder.iterdir()):
                raise DifferentError("a temporary file is left")
        if case.signal_at is not None:
            verdict.faults[signal_of(case.signal_at).name] += 1
        if case.death_after is not None:
            verdict.faults["worker killed"] += 1
        verdict.outcome = ends[0]


def _name(fault: DiskFault) -> str:
    if fault.kill:
        return "killed"
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
        with using(disk), signalled(signal_at, session.packages):
            session.attempt(folder, number, death)
    except Killed:
        return "killed"
    except KeyboardInterrupt as error:
        # Held back until the files were abandoned.
        return "not put back" if "put back" in str(error.__context__) else "interrupted"
    except (InputError, JobError) as error:
        if not disk.failed:
            raise
        return "not put back" if "put back" in str(error) else type(error).__name__
    return "done"


@cache
def _session(name: str) -> DiskSession:
    return DISK_SESSIONS[name]()


@cache
def _extent(name: str) -> DiskExtent:
    session, disk = _session(name), FaultyDisk()
    with in_folder() as folder:
        session.prepare(folder)
        with using(disk), counted_lines(session.packages) as lines:
            session.attempt(folder, 1, None)
    return DiskExtent(len(disk.calls), lines[0])
