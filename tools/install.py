"""Install the packages that setup.py finds missing; imports only the standard library."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path


# Optional dependencies of each level.
EXTRAS = {
    "plan": "",
    "test": "[docs,test]",
    "synth": "[docs,test,synth]",
    "long": "[docs,test,synth]",
}


class SetupError(Exception):
    """A missing package that cannot be installed here; the message is one sentence."""


def set_up(level: str, venv: Path, root: Path) -> None:
    """Install all packages of a level in ``venv``, and the project in editable mode.

    The environment is created if it is missing or belongs to another Python or folder. The kernels
    of the planners are compiled as soon as the packages for planning are there, beside the rest.

    Raises
    ------
    SetupError
        If a missing package cannot be installed here.
    """
    start = time.monotonic()
    require(["g++", "make"], "to build the simulated board")
    python = venv / "bin" / "python"
    if not venv_works(venv):
        make_venv(venv)
    say(f"installing packages for `{level}` into .venv")
    pip(python, "install", "--no-compile", "--editable", str(root))
    with compiled_kernels(python):
        if EXTRAS[level]:
            pip(python, "install", "--no-compile", "--editable", f"{root}{EXTRAS[level]}")
        # On all cores, because pip compiles on one. Some packages have files for other Pythons.
        compiling: list[str | Path] = [python, "-m", "compileall", "-q", "-j", "0", venv / "lib"]
        subprocess.run(compiling, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        if level != "plan":
            check_libpython(python)
            require_for_tests("iverilog", "for the tests on a second simulator")
            require_for_tests("chromium", "for the tests of pages in a browser")
        if level == "long":
            require_for_tests("dieharder", "for the battery of random tests")
    say(f"done in {time.monotonic() - start:.0f} s")


@contextlib.contextmanager
def compiled_kernels(python: Path) -> Iterator[None]:
    """Compile the planners' kernels beside the body, and wait for them at its end.

    A kernel that is not compiled here is compiled at its first use, so a failure only costs time
    later.
    """
    process = subprocess.Popen(
        [python, "-m", "pathgene.host.kernels"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        yield
        if process.poll() is None:
            say("compiling the planners' kernels")
        if process.wait() != 0:
            say("the kernels could not be compiled; the first plan compiles them.")
    finally:
        # All its processes, after an error or Ctrl-C.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def venv_works(venv: Path) -> bool:
    """Return whether the environment has this version of Python and was made at this path."""
    code = "import pip, sys; print(sys.prefix, *sys.version_info[:2])"
    try:
        found = subprocess.run(
            [venv / "bin" / "python", "-I", "-c", code], capture_output=True, text=True, check=True
        ).stdout.split()
        script = (venv / "bin" / "pip").read_text()
    except (OSError, subprocess.CalledProcessError):
        return False
    major, minor = sys.version_info[:2]
    return found == [str(venv), str(major), str(minor)] and str(venv) in script


def make_venv(venv: Path) -> None:
    """Replace the environment, first installing the Debian package that Python may lack."""
    package = f"python{sys.version_info.major}.{sys.version_info.minor}-venv"
    if importlib.util.find_spec("ensurepip") is None:
        install([package], f"{sys.executable} cannot make virtual environments")
    say(f"making .venv with {sys.executable}")
    shutil.rmtree(venv, ignore_errors=True)
    # This Python may belong to the environment just removed, so use the one it was made from.
    base = getattr(sys, "_base_executable", sys.executable)
    done = subprocess.run([base, "-m", "venv", venv], stdout=sys.stderr, check=False)
    if done.returncode != 0:
        shutil.rmtree(venv, ignore_errors=True)
        raise SetupError(f"{base} could not make .venv; install the Debian package {package}.")


def pip(python: Path, *arguments: str) -> None:
    """Run pip; print its output only if it fails."""
    command: list[str | Path] = [python, "-m", "pip", "--disable-pip-version-check", *arguments]
    done = subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    if done.returncode != 0:
        print(done.stdout, file=sys.stderr)
        raise SetupError("pip failed, for the reason above; check the network and try again.")


def check_libpython(python: Path) -> None:
    """Install the shared library of Python, which cocotb loads into the simulator."""
    code = "import find_libpython; print(find_libpython.find_libpython() or '')"
    found = subprocess.run([python, "-c", code], capture_output=True, text=True, check=False)
    if not found.stdout.strip():
        package = f"libpython{sys.version_info.major}.{sys.version_info.minor}"
        install([package], "cocotb needs Python as a shared library")


def require_for_tests(command: str, purpose: str) -> None:
    """Call :func:`require`; if it fails, report that the tests with ``command`` are skipped."""
    try:
        require([command], purpose)
    except SetupError as error:
        say(f"{error} Until then the tests with it are skipped.")


def require(commands: Sequence[str], purpose: str) -> None:
    """Install missing commands from the Debian packages of the same names."""
    missing = [name for name in commands if shutil.which(name) is None]
    if missing:
        install(missing, f"{' and '.join(missing)} missing {purpose}")


def install(packages: Sequence[str], reason: str) -> None:
    """Install Debian packages.

    Raises
    ------
    SetupError
        If this is not possible here; the message names them.
    """
    names = " ".join(packages)
    error = SetupError(f"{reason}; install the Debian package {names}.")
    prefix = privilege()
    if prefix is None or shutil.which("apt-get") is None:
        raise error
    say(f"{reason}: apt-get install {names}")
    # The package lists of a fresh container are empty; update them only if an install fails.
    for update in (False, True):
        if update:
            apt(prefix, "update")
        if apt(prefix, "install", "--no-install-recommends", *packages):
            return
    raise error


def privilege() -> list[str] | None:
    """Return the command prefix for root's rights without a password; None if there is none."""
    if os.geteuid() == 0:
        return []
    if shutil.which("sudo") is None:
        return None
    allowed = subprocess.run(["sudo", "-n", "true"], capture_output=True, check=False)
    return ["sudo", "-n"] if allowed.returncode == 0 else None


def apt(prefix: Sequence[str], action: str, *arguments: str) -> bool:
    """Run apt-get without questions; return whether it succeeded."""
    command = [*prefix, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq", "-y", action]
    done = subprocess.run([*command, *arguments], capture_output=True, check=False)
    return done.returncode == 0


def say(text: str) -> None:
    """Report progress."""
    print(f"setup: {text}", file=sys.stderr, flush=True)
