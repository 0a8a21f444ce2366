"""Functions that add logic to a module: multiplexers, delay lines, equal registers, assignments."""

import functools
import operator
from collections.abc import Iterable, Sequence

from amaranth import *
from amaranth.hdl import Cat, Module, Mux, Signal, Value
from amaranth.utils import ceil_log2


__all__ = [
    "assign_each",
    "delay_line",
    "fanout",
    "multiplex",
    "one_hot_multiplex",
    "one_hot_multiplex_tree",
]


def assign_each(targets: Iterable[Value], sources: Iterable[Value]) -> list:
    """Return the assignments of each of ``sources`` to its target; both have equal length."""
    return [target.eq(source) for target, source in zip(targets, sources, strict=True)]


# Inputs of a lookup table in common FPGAs; two joined tables have more.
_TABLE_INPUTS = 4


def multiplex(index: Value, items: Sequence[Value]) -> Value:
    """Return ``items[index]`` as a tree of two-way multiplexers; the highest bit is at its root.

    An index past the end selects an arbitrary item. Indexing a view of an array would shift the
    whole array, which is slow to simulate and takes much logic.
    """
    if len(items) == 1:
        return items[0]
    bits = ceil_log2(len(items)) - 1
    half = 1 << bits
    low = index[:bits]
    return Mux(index[bits], multiplex(low, items[half:]), multiplex(low, items[:half]))


def one_hot_multiplex(select: Value, items: Sequence[Value]) -> Value:
    """Return the item whose bit of ``select`` is set, or 0 if none is; at most one bit may be set.

    If the decoded selection is in a register, this is smaller than :func:`multiplex` with
    four-input tables, and each wire of ``select`` drives as many loads as an item has bits instead
    of half of all loads.
    """
    return _or(item & bit.replicate(len(item)) for bit, item in zip(select, items, strict=True))


def one_hot_multiplex_tree(m: Module, select: Value, items: Sequence[Value], name: str) -> Value:
    """Return :func:`one_hot_multiplex` as a tree of tables that synthesis preserves.

    A mapper that sees longer paths elsewhere would make a chain of the same size instead, which is
    too slow if the items come from across the chip. Wires of the tree are called ``name`` with
    numbers.
    """
    size = len(items[0])
    bits = list(select)
    at_once = _TABLE_INPUTS // 2
    parts = [
        one_hot_multiplex(Cat(bits[first : first + at_once]), items[first : first + at_once])
        for first in range(0, len(items), at_once)
    ]
    level = 0
    while len(parts) > 1:
        wires = [
            Signal(size, name=f"{name}_{level}_{number}", attrs={"keep": 1})
            for number in range(len(parts))
        ]
        m.d.comb += [wire.eq(part) for wire, part in zip(wires, parts, strict=True)]
        parts = [
            _or(wires[first : first + _TABLE_INPUTS])
            for first in range(0, len(wires), _TABLE_INPUTS)
        ]
        level += 1
    return parts[0]


def _or(terms: Iterable[Value]) -> Value:
    return functools.reduce(operator.or_, terms)


def delay_line(m: Module, value: Value, cycles: int, name: str) -> Value:
    """Return ``value`` from ``cycles`` cycles ago, through registers without reset.

    A value without bits is returned unchanged, because Verilog has no registers of zero width.
    """
    if Shape.cast(value.shape()).width == 0:
        return value
    for cycle in range(1, cycles + 1):
        earlier = Signal(value.shape(), name=f"{name}_{cycle}", reset_less=True)
        m.d.sync += earlier.eq(value)
        value = earlier
    return value


def fanout(m: Module, *values: Value, name: str, init: int = 0) -> list[Signal]:
    """Return a register in the domain ``sync`` for each of ``values``, which are all equal.

    A wire across the chip takes a cycle, and a register that drives a thousand registers is far
    from most of them; a copy can be placed among its loads. The attribute ``keep`` of the copies
    tells a board's synthesis not to merge them again.
    """
    registers = [
        Signal(len(value), name=f"{name}_{number}", init=init, attrs={"keep": 1})
        for number, value in enumerate(values)
    ]
    m.d.sync += [register.eq(value) for register, value in zip(registers, values, strict=True)]
    return registers
