"""Multiplexers of many inputs."""

import functools
import operator
from collections.abc import Sequence

from amaranth.hdl import Mux, Value
from amaranth.utils import ceil_log2


__all__ = ["chosen", "gated"]


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
    terms = [
        item & bit.replicate(len(item)) for bit, item in zip(select, items, strict=True)
    ]
    return functools.reduce(operator.or_, terms)
