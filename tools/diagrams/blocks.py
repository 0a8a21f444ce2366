"""Block diagrams of the chip, both genetic cores and the host, as DOT graphs."""

from __future__ import annotations

import html
import importlib
import inspect
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import grimp
from amaranth.hdl import ClockSignal, Fragment, ResetSignal, Value
from amaranth.lib import wiring

from pathgene.hdl.planner.core import PlannerCore
from pathgene.hdl.top import Chip
from tools.protocol_page.frames import PLANNER, SMALL


_CLOCKING = (ClockSignal, ResetSignal)
_ROOT = Path(__file__).resolve().parents[2]


@dataclass
class Unit:
    """One component in the elaborated hierarchy."""

    name: str
    fragment: Any
    component: Any
    units: dict[str, Unit] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """Name of the component's class."""
        return type(self.component).__name__

    @property
    def file(self) -> str:
        """Source file of the class, relative to the repository."""
        return str(Path(inspect.getfile(type(self.component))).resolve().relative_to(_ROOT))

    def find(self, kind: str) -> Unit:
        """Return the only unit of a class, at any depth.

        Raises
        ------
        LookupError
            If there is none, or more than one.
        """
        found = [unit for unit in self.walk() if unit.kind == kind]
        if len(found) != 1:
            raise LookupError(f"Units of class {kind} must be one, not {len(found)}")
        return found[0]

    def walk(self) -> Iterator[Unit]:
        """Yield this unit and all units inside it."""
        yield self
        for unit in self.units.values():
            yield from unit.walk()

    def connections(self) -> dict[tuple[str, str], list[str]]:
        """Return the outputs that connect each pair of units, indexed by (source, target).

        The name of this unit stands for its own ports. The `ready` of streams is left out because
        it runs in the opposite direction.
        """
        ports: dict[int, tuple[str, str]] = {}
        for unit in (*self.units.values(), self):
            for path, signals in _ports(unit.component):
                if path[-1] != "ready":
                    for signal in signals:
                        ports[id(signal)] = unit.name, str(path[0])
        feeds: dict[int, set[int]] = {}
        for lhs, rhs in _assignments(self.fragment):
            for target in lhs:
                feeds.setdefault(id(target), set()).update(map(id, rhs))
        found: dict[tuple[str, str], list[str]] = {}
        for target in feeds:
            if target not in ports:
                continue
            for source in _sources(target, feeds, ports):
                pair = ports[source][0], ports[target][0]
                if pair[0] != pair[1]:
                    names = found.setdefault(pair, [])
                    if ports[source][1] not in names:
                        names.append(ports[source][1])
        return found


def units_of(component: Any) -> Unit:
    """Elaborate a component and return it with its units."""
    return _unit("", Fragment.get(component, None))


def _unit(name: str, fragment: Any) -> Unit:
    component = next(
        origin for origin in reversed(fragment.origins) if isinstance(origin, wiring.Component)
    )
    unit = Unit(name, fragment, component)
    for inner, inner_name, _ in fragment.subfragments:
        origins = getattr(inner, "origins", None) or ()
        if any(isinstance(origin, wiring.Component) for origin in origins):
            unit.units[inner_name] = _unit(inner_name, inner)
    return unit


def _ports(component: Any) -> Iterator[tuple[tuple[Any, ...], list[Any]]]:
    for path, _, value in component.signature.flatten(component):
        yield path, list(Value.cast(value)._rhs_signals())


def _assignments(fragment: Any) -> Iterator[tuple[list[Any], list[Any]]]:
    """Yield the signals on both sides of every assignment."""

    def walk(statements: Iterable[Any]) -> Iterator[Any]:
        for statement in statements:
            if hasattr(statement, "cases"):
                for _, inner, _ in statement.cases:
                    yield from walk(inner)
            elif not isinstance(statement.lhs, _CLOCKING) and not isinstance(
                statement.rhs, _CLOCKING
            ):
                yield list(statement.lhs._lhs_signals()), list(statement.rhs._rhs_signals())

    for statements in fragment.statements.values():
        yield from walk(statements)


def _sources(target: int, feeds: dict[int, set[int]], ports: dict[int, Any]) -> list[int]:
    """Return the ports that feed a port, through the signals in between."""
    found, seen, open_ends = [], {target}, [target]
    while open_ends:
        for source in sorted(feeds.get(open_ends.pop(), ())):
            if source in seen:
                continue
            seen.add(source)
            if source in ports:
                found.append(source)
            else:
                open_ends.append(source)
    return found


_HEAD = """digraph {
  graph [rankdir=%s, fontname="Helvetica", nodesep=0.45, ranksep=0.6, pad=0.4, bgcolor="white"]
  node [shape=box, style="rounded,filled", fillcolor="%s", fontname="Helvetica", fontsize=12,
    margin="0.25,0.1"]
  edge [fontname="Helvetica", fontsize=9, color="#406080", fontcolor="#203040", arrowsize=0.7]
"""
_BLUE, _GREY = "#e8f0fa", "#f4f4f4"
#: Packages in the host's picture, in addition to the folders of host.
_NEIGHBOURS = (
    "pathgene.hdl.config",
    "pathgene.hdl.protocol",
    "pathgene.hdl.verilog",
    "pathgene",
    "pathgene.sim.board",
    "pathgene.sim.model",
)


def graphs() -> dict[str, str]:
    """Return the graphs by name."""
    top = chip()
    planner = units_of(PlannerCore(PLANNER))
    return {
        "chip": _units_graph(top, "the line"),
        "core": _units_graph(top.find("PaperCore"), "the rest of the chip"),
        "host": _host_graph(),
        "planner_core": _units_graph(
            planner, "the commands", hidden=("NearestCorner", "RunStatus"), steady=("problems",)
        ),
        "evolver": _units_graph(planner.find("Evolver"), "the rest of the core"),
        "evaluator": _units_graph(planner.find("PathEvaluator"), "the rest of the core"),
    }


def chip() -> Unit:
    """Return the units of the protocol page's small chip, which has every unit."""
    return units_of(Chip(SMALL))


def _units_graph(
    whole: Unit, outside: str, hidden: Sequence[str] = (), steady: Sequence[str] = ()
) -> str:
    """Return the units of ``whole``, without the ``hidden`` kinds and the ``steady`` signals."""
    lines = [_HEAD % ("TB", _BLUE)]
    units = {name: unit for name, unit in whole.units.items() if unit.kind not in hidden}
    names = {whole.name, *units}
    feeds = {
        ends: [signal for signal in signals if signal not in steady]
        for ends, signals in whole.connections().items()
        if names.issuperset(ends)
    }
    feeds = {ends: signals for ends, signals in feeds.items() if signals}
    # A skid buffer counts as part of the wire.
    for name, unit in whole.units.items():
        if unit.kind == "SkidBuffer" and name in units:
            feeds = _joined(feeds, name)
            del units[name]
    for name, unit in units.items():
        lines.append(f"  {name} [label=<{_label(unit)}>]")
    lines.append(f'  outside [label="{outside}", shape=plaintext, style="", fontsize=11]')
    control = {name for name, unit in units.items() if unit.kind in ("Control", "RunControl")}
    for (source, target), outputs in sorted(feeds.items()):
        steering = {source, target} & control
        style = ', style=dashed, color="#909090", fontcolor="#707070"' if steering else ""
        shown = {whole.name: "outside"}
        ends = f"{shown.get(source, source)} -> {shown.get(target, target)}"
        lines.append(f'  {ends} [label="{_wrapped(sorted(outputs))}"{style}]')
    return "\n".join([*lines, "}", ""])


def _joined(
    feeds: Mapping[tuple[str, str], list[str]], buffer: str
) -> dict[tuple[str, str], list[str]]:
    """Return ``feeds`` without ``buffer``, with its inputs joined to its outputs."""
    sources = [(source, names) for (source, target), names in feeds.items() if target == buffer]
    targets = [target for source, target in feeds if source == buffer]
    kept = {pair: list(names) for pair, names in feeds.items() if buffer not in pair}
    for source, names in sources:
        for target in targets:
            kept.setdefault((source, target), []).extend(names)
    return kept


def _label(unit: Unit) -> str:
    inner = list(dict.fromkeys(one.kind for one in unit.units.values()))
    inner = [kind for kind in inner if kind not in ("SkidBuffer", "StreamRegister", "Memory")]
    lines = [f"<b>{unit.kind}</b>", f'<font point-size="9">{unit.file}</font>']
    if inner:
        folded = textwrap.wrap(", ".join(inner), 38)
        lines += [f'<font point-size="8" color="#506070">{line}</font>' for line in folded]
    return "<br/>".join(lines)


def _wrapped(names: Iterable[str]) -> str:
    return "\\n".join(textwrap.wrap(", ".join(names), 22))


def _host_graph() -> str:
    graph = grimp.build_graph("pathgene")
    folders = sorted(graph.find_children("pathgene.host"))
    boxes = {box: {box, *graph.find_descendants(box)} for box in (*folders, *_NEIGHBOURS)}
    boxes["pathgene"] = {"pathgene"}  # Only the public API, without the folders.
    boxes = {box: modules for box, modules in boxes.items() if modules & graph.modules}
    owner = {module: box for box, modules in boxes.items() for module in modules}
    uses: dict[str, set[str]] = {box: set() for box in boxes}
    for module, box in owner.items():
        for imported in graph.find_modules_directly_imported_by(module):
            if owner.get(imported, box) != box:
                uses[box].add(owner[imported])
    lines = [_HEAD % ("TB", _BLUE)]
    for box in boxes:
        fill = "" if box.startswith("pathgene.host") else f', fillcolor="{_GREY}"'
        lines.append(f'  "{_short(box)}" [label=<{_described(box)}>{fill}]')
    for box, used in sorted(uses.items()):
        # An arrow is left out if it is implied by a path through another box.
        direct = sorted(map(_short, used - _beyond(uses, used)))
        lines += [f'  "{_short(box)}" -> "{other}"' for other in direct]
    return "\n".join([*lines, "}", ""])


def _described(module: str) -> str:
    """Return a label: a module's name above the first sentence of its docstring."""
    docstring = (importlib.import_module(module).__doc__ or "").split("\n\n")[0]
    docstring = docstring.replace("`", "").replace("*", "")
    sentence = " ".join(docstring.split()).partition(". ")[0].rstrip(".")
    folded = [html.escape(line) for line in textwrap.wrap(sentence, 34)]
    small = "<br/>".join(f'<font point-size="9">{line}</font>' for line in folded)
    return f"<b>{_short(module)}</b><br/>{small}"


def _short(module: str) -> str:
    """Return a module's name without the package."""
    return module.removeprefix("pathgene.")


def _beyond(uses: Mapping[str, set[str]], boxes: Iterable[str]) -> set[str]:
    """Return every box that ``boxes`` use, directly or indirectly."""
    found: set[str] = set()
    open_ends = list(boxes)
    while open_ends:
        for other in uses[open_ends.pop()]:
            if other not in found:
                found.add(other)
                open_ends.append(other)
    return found
