"""The runs of a comparison on disk: each is kept as soon as it has ended."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from host.compare.entrants import Entrant
from host.errors import InputError
from host.report.files import is_special
from host.report.summary import version


__all__ = ["RunStore"]

Record = dict[str, Any]


class RunStore:
    """One JSON object a line in ``runs.jsonl``, appended, never rewritten.

    Runs of other planners and options lie side by side, told apart by their key; those of another
    problem are refused. A line that a crash has cut off is passed over. One process at a time may
    have it open.

    Parameters
    ----------
    directory : Path
        Where the file is, or will be; exists.
    problem : str
        What :func:`host.compare.digest.problem_digest` says of the problem.

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
            self._file = self.path.open("a+b")
        except OSError as error:
            raise InputError(
                f"Cannot write to {str(self.path)!r} ({error.strerror or error}); "
                "give another directory with --out."
            ) from None
        try:
            self._lock()
            self._read()
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        # Every run has been flushed, and an error of that told.
        with contextlib.suppress(OSError):
            self._file.close()

    def get(self, entrant: Entrant, seed: int) -> Record | None:
        """The run of ``entrant`` with ``seed``, if there is one."""
        return self._records.get((entrant.key, seed))

    def add(self, entrant: Entrant, seed: int, record: Record) -> Record:
        """Keep a run, and return it as :meth:`get` will: it is on the disk then.

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
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            raise InputError(
                f"Cannot write to {str(self.path)!r} ({error.strerror or error}); "
                "mend that and give the same command again."
            ) from None
        self._records[entrant.key, seed] = line
        return line

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
                record = json.loads(line)
                if record["problem"] != self._problem:
                    raise InputError(
                        f"The directory {str(self.path.parent)!r} holds runs of another problem; "
                        f"give another with --out, or remove {str(self.path)!r}."
                    )
                self._records[record["key"], record["seed"]] = record
        if not line.endswith(b"\n"):
            self._file.write(b"\n")  # What follows the torn line is whole again.
