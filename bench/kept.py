"""Results of single runs, kept as soon as they are there."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any, TypeVar

from bench.sources import digest
from pathgene.host.cores import available_cores
from pathgene.host.errors import InputError
from pathgene.host.files.output import replacing


__all__ = ["Kept", "measure"]

Result = dict[str, Any]
Task = TypeVar("Task", bound=tuple[Any, ...])
Measured = TypeVar("Measured")


class Kept:
    """Results by row and part of the row, in a JSON file that is committed.

    The file is written as soon as a result is there, so an interrupted run continues, on another
    machine, too. A result follows from sources: after a change of their code it counts as
    missing, and is replaced when it is measured again.

    Parameters
    ----------
    file : Path
        The file; without it there are no results.
    *sources : str
        Folders and files for :func:`bench.sources.digest`.

    Raises
    ------
    InputError
        If the file is not one of results.
    """

    def __init__(self, file: Path, *sources: str) -> None:
        self._file, self._sources = file, digest(*sources)
        try:
            text = file.read_text("utf-8")
        except FileNotFoundError:
            text = "{}"
        try:
            self._rows: dict[str, dict[str, Result]] = json.loads(text)
        except ValueError:
            raise InputError(f"{file} holds no results; remove it or restore it.") from None

    def get(self, row: str, part: str) -> Result | None:
        """Return the result of a part of a row; None if it is missing."""
        result = self._rows.get(row, {}).get(part)
        if result is None or result["sources"] != self._sources:
            return None
        return {key: value for key, value in result.items() if key != "sources"}

    def keep(self, row: str, part: str, result: Result) -> None:
        """Keep a result: a dictionary of JSON values."""
        self._rows.setdefault(row, {})[part] = {"sources": self._sources, **result}
        with replacing(self._file) as file:
            file.write(self._text().encode())

    def _text(self) -> str:
        """Return the content of the file: a line a result."""
        rows = []
        for row, parts in sorted(self._rows.items()):
            lines = ",\n".join(
                f"  {json.dumps(part)}: {json.dumps(result, allow_nan=False)}"
                for part, result in sorted(parts.items())
            )
            rows.append(f" {json.dumps(row)}: {{\n{lines}\n }}")
        return "{\n" + ",\n".join(rows) + "\n}\n"


def measure(
    bench: str,
    tasks: Sequence[Task],
    work: Callable[..., Measured],
    keep: Callable[[Task, Measured], str],
) -> None:
    """Measure tasks in processes, one a core, and keep each result as soon as it is there.

    An interrupt gives up the tasks that have not begun.

    Parameters
    ----------
    bench : str
        Name of the benchmark, for the progress on standard error.
    tasks : sequence of tuple
        Arguments of ``work``.
    work : callable
        Runs in a process.
    keep : callable
        Called with a task and its result; keeps it and returns its name.
    """
    started = time.monotonic()
    with ProcessPoolExecutor(available_cores()) as pool:
        try:
            jobs = {pool.submit(work, *task): task for task in tasks}
            for done, job in enumerate(as_completed(jobs), 1):
                name = keep(jobs[job], job.result())
                minutes = (time.monotonic() - started) / 60
                print(
                    f"{bench}: {name} ({done} of {len(jobs)}, {minutes:.1f} min)",
                    file=sys.stderr,
                    flush=True,
                )
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
