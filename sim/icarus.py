"""Verilog to simulations with Icarus: the only module that knows how Icarus is called."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from host.errors import JobError
from sim.cache import BuildCache, digest
from sim.compiler import compile_object, run_tool


__all__ = ["build_icarus", "build_icarus_module", "icarus_version"]


@cache
def icarus_version() -> str:
    """Return the version line of Icarus Verilog: a part of build keys.

    Raises
    ------
    JobError
        If Icarus is not installed.
    """
    if shutil.which("iverilog") is None:
        raise JobError("Icarus Verilog is not installed; install the Debian package iverilog.")
    return run_tool(["iverilog", "-V"], cwd=Path.cwd(), what="Icarus Verilog").splitlines()[0]


def build_icarus(builds: BuildCache, verilog: str, tops: Sequence[str]) -> Path:
    """Compile Verilog with Icarus.

    Parameters
    ----------
    builds : BuildCache
        Where the compiled design is kept; a second call with equal arguments only looks it up.
    verilog : str
        Text of the design and everything around it.
    tops : Sequence[str]
        Modules that no other module instantiates, the design's first.

    Returns
    -------
    Path
        The compiled design.

    Raises
    ------
    JobError
        If Icarus is missing or refuses the design.
    """

    def build(directory: Path) -> None:
        (directory / "design.v").write_text(verilog)
        roots = [word for top in tops for word in ("-s", top)]
        # Verilog-2005: in SystemVerilog, `always @*` over constants at power-up would stay X.
        run_tool(
            ["iverilog", "-g2005", *roots, "-o", directory / "sim.vvp", directory / "design.v"],
            cwd=directory,
            what="Icarus Verilog",
        )

    key = digest([icarus_version(), verilog, *tops])
    return builds.get(f"icarus-{tops[0]}-{key}", build) / "sim.vvp"


def build_icarus_module(builds: BuildCache, sources: Sequence[Path]) -> Path:
    """Compile C++ to a VPI module for Icarus, named after the first file.

    Parameters
    ----------
    builds : BuildCache
        Keeps the module.
    sources : Sequence[Path]
        C++ files.

    Returns
    -------
    Path
        The module, ``NAME.vpi``.

    Raises
    ------
    JobError
        If Icarus or the compiler is missing, or the compiler refuses the files.
    """
    version = icarus_version()
    printed = run_tool(["iverilog-vpi", "--cflags"], cwd=Path.cwd(), what="Icarus Verilog")
    include = [word for word in printed.split() if word.startswith("-I")]
    objects = [compile_object(builds, path, include, key=version) for path in sources]
    name = sources[0].stem

    def build(directory: Path) -> None:
        output = directory / f"{name}.vpi"
        command: list[str | Path] = ["g++", "-shared", *objects, "-o", output]
        run_tool(command, cwd=directory, what=f"Linking {output.name}")

    key = digest(str(path) for path in objects)
    return builds.get(f"module-{name}-{key}", build) / f"{name}.vpi"
