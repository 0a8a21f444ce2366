"""Runner of cocotb benches on exported Verilog, with Icarus and Verilator.

A bench is a file ``cosim_NAME.py`` with cocotb tests and a module-level ``TOP``, the name of a top
in ``pathgene.hdl.verilog.TOPS`` and of its Verilog module. An optional ``CONFIG`` is the
configuration of the export and defaults to ``Config()``.

``python -m tools.runner --sim icarus --bench uart --waves`` runs one of ``tests/cosim``.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from pathgene.host.errors import InputError, PathgeneError
from pathgene.sim.board.programs import Simulator
from pathgene.sim.cache import BuildCache, build_root
from pathgene.sim.icarus import build_icarus
from pathgene.sim.verilator import build_verilator


if TYPE_CHECKING:
    from pathgene.hdl.config import Config


SIMULATORS: tuple[Simulator, ...] = ("icarus", "verilator")

#: Folder of the project's benches.
BENCHES = Path(__file__).resolve().parents[1] / "tests" / "cosim"

# A module separate from the design, so that the same compiled design runs with and without a
# waveform.
_ICARUS_WAVES = """
module waves;
    reg [8 * 4096 - 1:0] path;
    initial if ($value$plusargs("waves=%s", path)) begin
        $dumpfile(path);
        $dumpvars(0, {top});
    end
endmodule
"""


class CosimError(AssertionError):
    """A bench failed; the message names the failing tests and the log."""


@dataclass(frozen=True)
class CosimResult:
    """A bench that passed."""

    #: Number of tests that ran, skipped tests excluded; 1 or more.
    tests: int
    log: Path
    #: Waveform, FST from Icarus and VCD from Verilator.
    waves: Path | None
    #: Time of the simulation, without builds.
    seconds: float


def run(
    sim: Simulator,
    verilog: str | Path,
    top: str,
    bench: Path,
    *,
    env: Mapping[str, str] | None = None,
    label: str | None = None,
    waves: bool = False,
    seed: int = 1,
    test_filter: str | None = None,
    timeout_s: float = 900.0,
    build_dir: Path | None = None,
) -> CosimResult:
    """Simulate a design with the cocotb tests of one file, and check their results.

    The design, a text or a file, is built once per simulator and text. Several processes can run
    benches at the same time; runs with the same ``label`` overwrite each other's log. Modules next
    to the ``bench`` can be imported; ``env`` adds environment variables, ``waves`` records a
    waveform of everything, ``seed`` is of :mod:`random` in the bench, ``test_filter`` is a regular
    expression.

    Raises
    ------
    CosimError
        If a test failed, no test ran, or the simulator ended early or exceeded its time.
    JobError
        If a tool is missing or refuses the design.
    """
    root = build_root() if build_dir is None else build_dir
    text = verilog.read_text() if isinstance(verilog, Path) else verilog
    program = _build(BuildCache(root / "sim"), sim, text, top, waves=waves)
    label = label or f"{bench.stem.removeprefix('cosim_')}-{sim}"
    output = root / "cosim"
    output.mkdir(parents=True, exist_ok=True)
    log = output / f"{label}.log"
    waves_name = "waves.fst" if sim == "icarus" else "waves.vcd"
    with tempfile.TemporaryDirectory(prefix=f"{label}.", dir=output) as work:
        directory = Path(work)
        variables = {
            **_environment(sim, top, bench),
            "COCOTB_RESULTS_FILE": str(directory / "results.xml"),
            "COCOTB_RANDOM_SEED": str(seed),
            **({} if test_filter is None else {"COCOTB_TEST_FILTER": test_filter}),
            **(env or {}),
        }
        start = time.monotonic()
        with (directory / "log").open("wb") as file:
            try:
                status = subprocess.run(
                    _command(sim, program, directory / waves_name if waves else None),
                    cwd=directory,
                    env=variables,
                    stdin=subprocess.DEVNULL,
                    stdout=file,
                    stderr=subprocess.STDOUT,
                    timeout=timeout_s,
                    check=False,
                ).returncode
            except subprocess.TimeoutExpired:
                status = None
        seconds = time.monotonic() - start
        (directory / "log").replace(log)
        kept = None
        if waves and (directory / waves_name).exists():
            kept = output / f"{label}{Path(waves_name).suffix}"
            (directory / waves_name).replace(kept)
        if status is None:
            raise CosimError(f"{label} did not end within {timeout_s:g} s; its log is {log}")
        tests = _check(directory / "results.xml", label, log, status)
    return CosimResult(tests, log, kept, seconds)


def run_bench(
    sim: Simulator, bench: Path, *, waves: bool = False, build_dir: Path | None = None
) -> CosimResult:
    """Run one bench on the top level that it names; parameters and errors as in :func:`run`.

    Raises
    ------
    InputError
        If the bench names no top level.
    """
    from pathgene.sim.exported import exported_verilog

    top, config = _subject(bench)
    text = exported_verilog(top, config)
    return run(sim, text, top, bench, waves=waves, build_dir=build_dir)


def benches(directory: Path = BENCHES) -> dict[str, Path]:
    """Return the bench files of a directory by name, in alphabetical order."""
    return {path.stem.removeprefix("cosim_"): path for path in sorted(directory.glob("cosim_*.py"))}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run benches from the command line; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tools.runner", description=__doc__)
    parser.add_argument("--sim", choices=SIMULATORS, help="default: all")
    parser.add_argument("--bench", metavar="NAME", help="default: all")
    parser.add_argument("--waves", action="store_true", help="leave a waveform of each run")
    options = parser.parse_args(arguments)
    found = benches()
    try:
        if options.bench is not None and options.bench not in found:
            raise InputError(f"No bench {options.bench!r}; choose from {', '.join(found)}.")
        chosen = [options.bench] if options.bench else list(found)
        for name in chosen:
            for sim in [options.sim] if options.sim else SIMULATORS:
                result = run_bench(sim, found[name], waves=options.waves)
                waves = "" if result.waves is None else f", waveform {result.waves}"
                print(
                    f"{name} on {sim}: {result.tests} passed in {result.seconds:.1f} s{waves}",
                    flush=True,
                )
    except CosimError as error:
        print(error, file=sys.stderr)
        return 1
    except PathgeneError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_status
    return 0


def _subject(bench: Path) -> tuple[str, Config]:
    """Return the top level and the configuration that a bench names."""
    from pathgene.hdl.config import Config

    spec = importlib.util.spec_from_file_location(bench.stem, bench)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(bench.parent))
    try:
        spec.loader.exec_module(module)
    finally:
        sys.path.remove(str(bench.parent))
    top = getattr(module, "TOP", None)
    if not isinstance(top, str):
        raise InputError(f"The bench {bench.name} must say TOP = 'name of a top', not {top!r}.")
    config = getattr(module, "CONFIG", None)
    return top, Config() if config is None else config


def _build(builds: BuildCache, sim: Simulator, text: str, top: str, *, waves: bool) -> Path:
    if sim == "icarus":
        text = f"`timescale 1ns / 1ps\n{text}\n{_ICARUS_WAVES.replace('{top}', top)}"
        return build_icarus(builds, text, [top, "waves"])
    from cocotb_tools import config

    libraries = str(config.libs_dir)
    return build_verilator(
        builds,
        text,
        top,
        main=config.share_dir / "lib" / "verilator" / "verilator.cpp",
        # A bench needs visible and writable ports, which make the simulation several times slower.
        verilate_args=["--vpi", "--timescale", "1ns/1ps"],
        public=True,
        link_args=[f"-Wl,-rpath,{libraries}", f"-L{libraries}", "-lcocotbvpi_verilator"],
        optimize="-O0",  # VPI is the bottleneck; this reduces the compiler's time to a quarter.
        trace=waves,
    )


def _command(sim: Simulator, program: Path, waves: Path | None) -> list[str]:
    if sim == "verilator":
        return [str(program), *([] if waves is None else ["--trace", "--trace-file", str(waves)])]
    from cocotb_tools import config

    plugin = str(config.lib_entry("vpi", "icarus"))
    options = ["-none"] if waves is None else ["-fst", f"+waves={waves}"]
    return ["vvp", "-n", "-m", plugin, str(program), *options]


def _environment(sim: Simulator, top: str, bench: Path) -> dict[str, str]:
    """Return the environment in which cocotb finds Python and the tests."""
    import find_libpython
    from cocotb_tools import config

    library = find_libpython.find_libpython()
    if library is None:
        raise InputError(
            "cocotb needs Python's shared library; install the Debian package "
            f"libpython{sys.version_info.major}.{sys.version_info.minor}."
        )
    return {
        **os.environ,
        "COCOTB_TOPLEVEL": top,
        "COCOTB_TEST_MODULES": bench.stem,
        "COCOTB_TRUST_INERTIAL_WRITES": str(int(sim == "verilator")),
        "TOPLEVEL_LANG": "verilog",
        "GPI_USERS": f"{library};{config.pygpi_entry_point()}",
        "PYGPI_PYTHON_BIN": sys.executable,
        "PYTHONPATH": os.pathsep.join([str(bench.parent.resolve()), *sys.path]),
        "PATH": os.pathsep.join([os.environ.get("PATH", os.defpath), str(config.libs_dir)]),
    }


def _check(results: Path, label: str, log: Path, status: int) -> int:
    """Return the number of passed tests, or raise an error for failed ones."""
    if not results.is_file():
        raise CosimError(
            f"{label}: the simulator ended with status {status} before its results; log {log}"
        )
    cases = ElementTree.parse(results).getroot().findall(".//testcase")
    failed = [
        f"{case.get('name')} ({_first_line(case)})"
        for case in cases
        if case.find("failure") is not None or case.find("error") is not None
    ]
    if failed:
        raise CosimError(f"{label}: {len(failed)} failed: {', '.join(failed)}; log {log}")
    passed = sum(case.find("skipped") is None for case in cases)
    if passed == 0:
        raise CosimError(f"{label}: no test ran; log {log}")
    if status != 0:
        raise CosimError(f"{label}: the simulator ended with status {status}; log {log}")
    return passed


def _first_line(case: ElementTree.Element) -> str:
    for kind in ("failure", "error"):
        found = case.find(kind)
        if found is not None:
            return found.get("message", "").partition("\n")[0]
    return ""


if __name__ == "__main__":
    sys.exit(main())
