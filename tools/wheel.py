"""Build a wheel with compiled kernels: ``python -m tools.wheel --out DIR``.

The kernels are compiled for x86-64-v3, on any processor that has its features; a command of an
installed wheel loads them on such a processor, and compiles on any other. They belong to this
version of Python and of numba. Elsewhere than on Linux for x86-64-v3 the wheel has no kernels.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import llvmlite.binding
import numba
from numba.core.codegen import get_host_cpu_features

from pathgene.host.errors import JobError, PathgeneError
from pathgene.jit import BASELINE, baseline_target


__all__ = ["can_compile", "compile_kernels", "main", "make_wheel"]

ROOT = Path(__file__).resolve().parents[1]
# Everything that a wheel is made of. The last three folders are links inside the first.
_FOLDERS = ("pathgene", "hdl", "host", "sim")
_FILES = ("pyproject.toml", "README.md", "LICENSE")


def make_wheel(out: Path, *, with_kernels: bool) -> Path:
    """Build a wheel from the sources and return its path.

    Parameters
    ----------
    out : Path
        Folder that gets the wheel; made if it is missing.
    with_kernels : bool
        Whether to compile the kernels, which takes 75 processor seconds; see
        :func:`can_compile`.

    Raises
    ------
    JobError
        If a step fails; the exception's note has its output.
    """
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        wheel = _plain(folder)
        if with_kernels:
            _run(["wheel", "unpack", "--dest", folder / "unpacked", wheel], folder, "Unpacking")
            (tree,) = (folder / "unpacked").iterdir()
            compile_kernels(tree)
            (information,) = tree.glob("*.dist-info")
            _label(information / "WHEEL")
            (packed := folder / "packed").mkdir()
            # It writes the list of files with their digests.
            _run(["wheel", "pack", "--dest-dir", packed, tree], folder, "Packing")
            (wheel,) = packed.glob("*.whl")
        out.mkdir(parents=True, exist_ok=True)
        return Path(shutil.copy(wheel, out))


def can_compile() -> bool:
    """Return whether kernels for :data:`pathgene.jit.BASELINE` can be compiled and run here."""
    if sys.platform != "linux" or platform.machine() != "x86_64":
        return False
    target = llvmlite.binding.get_process_triple(), "", get_host_cpu_features()
    return baseline_target(target) is not None


def compile_kernels(tree: Path) -> None:
    """Compile the kernels of an unpacked wheel for the baseline, into its ``__pycache__``.

    Raises
    ------
    JobError
        If the compilation fails or leaves nothing; the exception's note has its output.
    """
    # Settings of numba and Python here, such as a folder for caches, do not concern the wheel.
    ours = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("NUMBA_", "PYTHON"))
    }
    environment = ours | {
        "NUMBA_CPU_NAME": BASELINE,
        "NUMBA_CPU_FEATURES": "",
        # A library of some machines, which numba would call from the kernels.
        "NUMBA_DISABLE_INTEL_SVML": "1",
        "PYTHONPATH": str(tree),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    _run(["pathgene.host.kernels"], tree, "Compiling the kernels", environment)
    if not any(tree.rglob("*.nbc")):
        raise JobError("The compilation left no kernels in the wheel; it needs numba's cache.")


def _plain(folder: Path) -> Path:
    """Build the wheel without kernels, from a copy, because a build leaves files there."""
    sources = folder / "sources"
    caches = shutil.ignore_patterns("__pycache__")
    for name in _FOLDERS:
        shutil.copytree(ROOT / name, sources / name, ignore=caches, symlinks=True)
    for name in _FILES:
        shutil.copy(ROOT / name, sources)
    _run(
        ["build", "--wheel", "--no-isolation", "--outdir", folder / "plain", sources],
        folder,
        "Building the wheel",
    )
    (wheel,) = (folder / "plain").glob("*.whl")
    return wheel


def _label(information: Path) -> None:
    """Label a wheel for this Python and platform, in its file ``WHEEL``."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    system = re.sub(r"\W", "_", sysconfig.get_platform())
    text = information.read_text()
    text = text.replace("Tag: py3-none-any", f"Tag: {python}-{python}{sys.abiflags}-{system}")
    information.write_text(text.replace("Root-Is-Purelib: true", "Root-Is-Purelib: false"))


def _run(
    module: Sequence[str | Path], cwd: Path, what: str, environment: Mapping[str, str] | None = None
) -> None:
    done = subprocess.run(
        [sys.executable, "-m", *module],
        cwd=cwd,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        error = JobError(f"{what} failed with status {done.returncode}.")
        error.add_note(done.stdout)
        raise error


def main(arguments: Sequence[str] | None = None) -> int:
    """Build a wheel, with kernels if this machine can compile them; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.wheel", description="Build a wheel with compiled kernels."
    )
    parser.add_argument("--out", type=Path, default=ROOT / "dist", help="folder (default dist/)")
    out = parser.parse_args(arguments).out
    if out.exists() and not out.is_dir():
        parser.error(f"{out} is no folder; name the folder of the wheel.")
    with_kernels = can_compile()
    if not with_kernels:
        print(
            f"The wheel has no kernels: they are for {BASELINE} under Linux, which this is not.",
            file=sys.stderr,
        )
    try:
        wheel = make_wheel(out, with_kernels=with_kernels)
    except (PathgeneError, OSError) as error:
        print(*getattr(error, "__notes__", []), f"error: {error}", sep="\n", file=sys.stderr)
        return 1
    print(wheel)
    if with_kernels:
        print(
            f"Its kernels need numba {numba.__version__}; with another version, pathgene compiles."
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
