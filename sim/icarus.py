"""Simulations built from Verilog by Icarus: the only module that knows how to call Icarus."""

from __future__ import annotations

import itertools
import re
import shutil
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from pathgene.host.errors import JobError
from pathgene.sim.cache import BuildCache, digest
from pathgene.sim.compiler import compile_object, run_tool


__all__ = ["build_icarus", "build_icarus_module", "icarus_version", "with_zeros"]

# A memory without initial contents in the export: its name and its last row; and the register of a
# read port, which never has an initial value.
_MEMORY = re.compile(
    r"\(\* no_rw_check = [^*]*\*\)\s*(?:\(\*[^*]*\*\)\s*)*"
    r"reg (?:\[\d+:0\] )?(\w+|\\\S+ )\s*\[(\d+):0\];\n"
)
_READ_PORT = re.compile(r"reg (?:\[\d+:0\] )?(_\d+_);\n")


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


def with_zeros(verilog: str) -> str:
    """Return exported Verilog in which memories and their read ports are initially zero.

    A chip's memory has arbitrary but definite contents at power-on. In Icarus they would be ``X``,
    and a register whose update depends on a comparison with ``X`` would remain ``X``, while the
    chip would update it.
    """
    rows = map("row_to_zero_{}".format, itertools.count())

    def memory(found: re.Match[str]) -> str:
        row, name, last = next(rows), found[1], found[2]
        loop = f"for ({row} = 0; {row} <= {last}; {row} = {row} + 1) {name}[{row}] = 0;"
        return f"{found[0]}  integer {row};\n  initial {loop}\n"

    text = _MEMORY.sub(memory, verilog)
    return _READ_PORT.sub(r"\g<0>  initial \1 = 0;\n", text)


def build_icarus(builds: BuildCache, verilog: str, tops: Sequence[str]) -> Path:
    """Compile Verilog with Icarus.

    Parameters
    ----------
    builds : BuildCache
        Keeps the compiled design; a second call with equal arguments only looks it up.
    verilog : str
        Text of the design and everything around it.
    tops : Sequence[str]
        Modules that no other module instantiates, beginning with the design's.

    Returns
    -------
    Path
        The compiled design.

    Raises
    ------
    JobError
        If Icarus is missing or refuses the design.
    """
    text = with_zeros(verilog)

    def build(directory: Path) -> None:
        (directory / "design.v").write_text(text)
        roots = [word for top in tops for word in ("-s", top)]
        # Verilog-2005: in SystemVerilog, `always @*` over constants at power-up would stay X.
        run_tool(
            ["iverilog", "-g2005", *roots, "-o", directory / "sim.vvp", directory / "design.v"],
            cwd=directory,
            what="Icarus Verilog",
        )

    key = digest([icarus_version(), text, *tops])
    return builds.get(f"icarus-{tops[0]}-{key}", build) / "sim.vvp"


def build_icarus_module(builds: BuildCache, sources: Sequence[Path]) -> Path:
    """Compile C++ to a VPI module for Icarus, named after the first file.

    Parameters
    ----------
    builds : BuildCache
        Keeps the module.

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
