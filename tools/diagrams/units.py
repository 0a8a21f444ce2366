"""The units of an elaborated component and the connections between their ports."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from amaranth.hdl import ClockSignal, Fragment, ResetSignal, Value
from amaranth.lib import wiring


__all__ = ["Unit", "units_of"]

_CLOCKING = (ClockSignal, ResetSignal)
_ROOT = Path(__file__).resolve().parents[2]


@dataclass
class Unit:
    """One component in the elaborated hierarchy.

    Attributes
    ----------
    name : str
        Name of the submodule.
    fragment : Fragment
    component : wiring.Component
    units : dict of str to Unit
        Components inside it, by name.
    """

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
