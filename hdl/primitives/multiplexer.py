"""Multiplexers of many inputs."""

import functools
import operator
from collections.abc import Iterable, Sequence

from amaranth.hdl import Cat, Module, Mux, Signal, Value
from amaranth.utils import ceil_log2


__all__ = ["chosen", "gated", "gated_tree"]

# Of the lookup tables of most FPGAs, without those that join two of them.
_TABLE_INPUTS = 4


def chosen(index: Value, items: Sequence[Value]) -> Value:
    """Return ``items[index]`` as a tree of two-way multiplexers; the highest bit is at its root.

    Indexing a view of an array makes a shift of the whole array: slow to simulate, large to build.
    An index past the end gives some item.
    """
    if len(items) == 1:
        return items[0]
    bits = ceil_log2(len(items)) - 1
    half = 1 << bits
    low = index[:bits]
    return Mux(index[bits], chosen(low, items[half:]), chosen(low, items[:half]))


def gated(select: Value, items: Sequence[Value]) -> Value:
    """Return the item whose bit of ``select`` is set: at most one may be; 0 if none is.

    Where a register holds the decoded choice, this is smaller than :func:`chosen` on tables of four
    inputs, and each wire of ``select`` drives as many loads as an item has bits, not half of all.
    """
    return _or(item & bit.replicate(len(item)) for bit, item in zip(select, items, strict=True))


def gated_tree(m: Module, select: Value, items: Sequence[Value], name: str) -> Value:
    """Return what :func:`gated` does, as a tree of tables that synthesis leaves as it is.

    A mapper that sees longer paths elsewhere makes a chain of it, of the same size: where the items
    come from the other end of the chip, there is no time left for that. Wires of the tree are
    called ``name`` with numbers.
    """
    size = len(items[0])
    bits = list(select)
    at_once = _TABLE_INPUTS // 2
    parts = [
        gated(Cat(bits[first : first + at_once]), items[first : first + at_once])
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
