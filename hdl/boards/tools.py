"""Programs that make bitstreams, from the package index or set in the environment."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterable, Sequence
from pathlib import Path


__all__ = ["BuildError", "Stamp", "run_tool", "start_tool", "tool_failed", "tool_path"]


class BuildError(Exception):
    """No bitstream could be made; the message is one sentence."""


def tool_path(tool: str) -> str:
    """Return the program to run as ``tool``, such as ``nextpnr-ecp5``.

    Raises
    ------
    BuildError
        If there is none.
    """
    named = os.environ.get(tool.upper().replace("-", "_"))
    path = shutil.which(
        named or f"yowasp-{tool}", path=None if named else sysconfig.get_path("scripts")
    )
    path = path or shutil.which(tool)
    if path is None:
        raise BuildError(f"{named or tool} is missing; `make bitstream` installs the open tools.")
    return path


class Stamp:
    """Marker next to the results of a long run, which then need not be repeated.

    The mark holds a digest of everything that the results depend on: the program, its arguments,
    and its input files.

    Parameters
    ----------
    arguments : sequence of str
    folder : Path
        Working directory of the tool, and place of the mark.
    inputs, outputs : iterable of str
        Names of the files in ``folder`` that the tool reads, and of the files that it writes.
    """

    #: Suffix of the mark's name, which begins with the tool's name.
    SUFFIX = ".stamp"

    def __init__(
        self,
        tool: str,
        arguments: Sequence[str],
        folder: Path,
        inputs: Iterable[str],
        outputs: Iterable[str],
    ) -> None:
        program = Path(tool_path(tool))
        changed = program.stat()
        digest = hashlib.sha256(
            repr((str(program), changed.st_size, changed.st_mtime_ns, *arguments)).encode()
        )
        for name in inputs:
            digest.update(hashlib.sha256((folder / name).read_bytes()).digest())
        self._digest = digest.hexdigest()
        self._outputs = [folder / name for name in outputs]
        self._file = folder / f"{tool}{self.SUFFIX}"

    def matches(self) -> bool:
        """Return whether the results exist and come from the same run."""
        return (
            all(file.exists() for file in (self._file, *self._outputs))
            and self._file.read_text(encoding="ascii") == self._digest
        )

    def clear(self) -> None:
        """Remove the mark: the results are about to change."""
        self._file.unlink(missing_ok=True)

    def set(self) -> None:
        """Mark the results as complete."""
        self._file.write_text(self._digest, encoding="ascii")


def start_tool(tool: str, arguments: Sequence[str], folder: Path) -> subprocess.Popen[bytes]:
    """Start ``tool`` in ``folder``, with its output in a log file there."""
    with _log(tool, folder).open("wb") as output:
        return subprocess.Popen(
            [tool_path(tool), *arguments], cwd=folder, stdout=output, stderr=subprocess.STDOUT
        )


def tool_failed(tool: str, folder: Path, status: int) -> BuildError:
    """Return the error of a failed ``tool``; print the end of its output."""
    log = _log(tool, folder)
    sys.stderr.write("".join(log.read_text(errors="replace").splitlines(True)[-20:]))
    return BuildError(f"{tool} failed with status {status}; its output is in {log}.")


def run_tool(tool: str, arguments: Sequence[str], folder: Path) -> None:
    """Run ``tool`` in ``folder``, with its output in a log file there.

    Raises
    ------
    BuildError
        If it fails; the end of its output is on standard error.
    """
    with start_tool(tool, arguments, folder) as running:
        try:
            status = running.wait()
        except BaseException:
            running.kill()
            raise
    if status != 0:
        raise tool_failed(tool, folder, status)


def _log(tool: str, folder: Path) -> Path:
    return folder / f"{tool}.log"
