"""The programs that make bitstreams, from the package index or named in the environment."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Sequence
from pathlib import Path


__all__ = ["BuildError", "run_tool", "start_tool", "tool_failed", "tool_path"]


class BuildError(Exception):
    """No bitstream; the message is one sentence."""


def tool_path(tool: str) -> str:
    """Return the program that is run as ``tool``, such as ``nextpnr-ecp5``.

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


def start_tool(tool: str, arguments: Sequence[str], folder: Path) -> subprocess.Popen[bytes]:
    """Start ``tool`` in ``folder``, its output in a log file there."""
    with _log(tool, folder).open("wb") as output:
        return subprocess.Popen(
            [tool_path(tool), *arguments], cwd=folder, stdout=output, stderr=subprocess.STDOUT
        )


def tool_failed(tool: str, folder: Path, status: int) -> BuildError:
    """Return the error of a ``tool`` that failed; show the end of its output."""
    log = _log(tool, folder)
    sys.stderr.write("".join(log.read_text(errors="replace").splitlines(True)[-20:]))
    return BuildError(f"{tool} failed with status {status}; its output is in {log}.")


def run_tool(tool: str, arguments: Sequence[str], folder: Path) -> None:
    """Run ``tool`` in ``folder``, its output in a log file there.

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
