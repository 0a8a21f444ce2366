"""The runs of a comparison on disk; each is stored as soon as it ends."""

from __future__ import annotations

import contextlib
import fcntl
import json
from pathlib import Path
from typing import Any, Self

from pathgene.host.compare.entrants import Entrant
from pathgene.host.errors import InputError
from pathgene.host.files.disk import current, sync_names
from pathgene.host.files.special import is_special
from pathgene.host.inputs import parse_json
from pathgene.host.numeric import is_number
from pathgene.host.report.summary import version


__all__ = ["RunStore"]

Record = dict[str, Any]


class RunStore:
    """A file ``runs.jsonl`` with one JSON object per line, only ever appended to.

    Runs of different planners and options share the file and differ by their key; runs of another
    problem are refused. A line that a crash cut off, or whose values are not those that a run has,
    is skipped. Only one process at a time may open the file.

    Parameters
    ----------
    problem : str
        Result of :func:`pathgene.host.compare.entrants.problem_digest`.

    Raises
    ------
    InputError
        If the file holds runs of another problem, another comparison has it open, or it cannot be
        read or written.
    """

    def __init__(self, directory: Path, problem: str) -> None:
        self.path = directory / "runs.jsonl"
        self._problem = problem
        self._records: dict[tuple[str, int], Record] = {}
        if is_special(self.path):
            raise InputError(
                f"{str(self.path)!r} is no regular file and cannot keep runs; remove "
                "it, or give another directory with --out."
            )
        try:
            self._file = current().append(self.path)
        except OSError as error:
            raise InputError(
                f"Cannot write to {str(self.path)!r} ({error.strerror or error}); "
                "give another directory with --out."
            ) from None
        try:
            self._lock()
            self._read()
            self._sync()
        except BaseException:
            self._close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._close()

    def get(self, entrant: Entrant, seed: int) -> Record | None:
        """Return the run of ``entrant`` with ``seed``, if there is one."""
        return self._records.get((entrant.key, seed))

    def add(self, entrant: Entrant, seed: int, record: Record) -> Record:
        """Store a run on disk; return it in the form that :meth:`get` returns.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        line = {
            "problem": self._problem,
            "key": entrant.key,
            "pathgene": version(),
            **entrant.describe(),
            "seed": seed,
            **record,
        }
        try:
            self._file.write(f"{json.dumps(line, allow_nan=False)}\n".encode())
            current().sync(self._file)
        except OSError as error:
            raise self._refused(error) from None
        self._records[entrant.key, seed] = line
        return line

    def _close(self) -> None:
        # Every run has been flushed, and errors have been reported; the file tries once more.
        with contextlib.suppress(OSError):
            self._file.close()

    def _sync(self) -> None:
        """Store the file's name, and the runs that a killed process wrote and did not sync."""
        try:
            current().sync(self._file)
        except OSError as error:
            raise self._refused(error) from None
        sync_names(self.path.parent)

    def _refused(self, error: OSError) -> InputError:
        return InputError(
            f"Cannot write to {str(self.path)!r} ({error.strerror or error}); "
            "correct that and give the same command again."
        )

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise InputError(
                f"Another comparison is writing to {str(self.path.parent)!r}; wait "
                "for it, or give another directory with --out."
            ) from None

    def _read(self) -> None:
        self._file.seek(0)
        line = b"\n"
        for line in self._file:
            with contextlib.suppress(ValueError, KeyError, TypeError):
                record = parse_json(line.decode())
                if record["problem"] != self._problem:
                    raise InputError(
                        f"The directory {str(self.path.parent)!r} holds runs of another problem; "
                        f"give another with --out, or remove {str(self.path)!r}."
                    )
                _require_record(record)
                self._records[record["key"], record["seed"]] = record
        if not line.endswith(b"\n"):
            self._file.write(b"\n")  # End the truncated line.


def _require_record(record: Record) -> None:
    """Raise ValueError, KeyError or TypeError if a run lacks a value that reports need."""
    history, spent = record["history"], record["history_evaluations"]
    if not (isinstance(history, list) and isinstance(spent, list)):
        raise TypeError("no history")
    entries = [(number, best) for number, best, *_ in history]
    numbers = [record[key] for key in ("fitness", "evaluations", "generations")]
    numbers += [record["seconds"]["total"], *spent, *(best for _, best in entries)]
    whole = [record["seed"], *(number for number, _ in entries)]
    if not (
        all(map(is_number, numbers))
        and all(isinstance(number, int) for number in whole)
        and isinstance(record["feasible"], bool)
        and isinstance(record["key"], str)
    ):
        raise TypeError("no run")
