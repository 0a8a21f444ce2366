"""Multiplexers of many inputs."""

import functools
import operator
from collections.abc import Iterable, Sequence

from amaranth.hdl import Cat, Module, Mux, Signal, Value
from amaranth.utils import ceil_log2


__all__ = ["multiplex", "one_hot_multiplex", "one_hot_multiplex_tree"]

# Inputs of a lookup table of most FPGAs; two joined tables have more.
_TABLE_INPUTS = 4


def multiplex(index: Value, items: Sequence[Value]) -> Value:
    """Return ``items[index]`` as a tree of two-way multiplexers; the highest bit is at its root.

    An index past the end selects an arbitrary item. Indexing a view of an array would shift the
    whole array, which is slow to simulate and large to build.
    """
    if len(items) == 1:
        return items[0]
    bits = ceil_log2(len(items)) - 1
    half = 1 << bits
    low = index[:bits]
    return Mux(index[bits], multiplex(low, items[half:]), multiplex(low, items[:half]))


def one_hot_multiplex(select: Value, items: Sequence[Value]) -> Value:
    """Return the item whose bit of ``select`` is set, 0 if none is; at most one bit is set.

    If a register holds the decoded choice, this is smaller than :func:`multiplex` in tables of
    four inputs, and each wire of ``select`` drives as many loads as an item has bits, not half of
    all loads.
    """
    return _or(item & bit.replicate(len(item)) for bit, item in zip(select, items, strict=True))


def one_hot_multiplex_tree(m: Module, select: Value, items: Sequence[Value], name: str) -> Value:
    """Return :func:`one_hot_multiplex` as a tree of tables that synthesis keeps.

    A mapper that sees longer paths elsewhere makes a chain of the same size instead, which is too
    slow where the items come from far across the chip. Wires of the tree are called ``name`` with
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
