"""Multiplexers of many inputs."""

from collections.abc import Sequence

from amaranth.hdl import Mux, Value
from amaranth.utils import ceil_log2


__all__ = ["chosen"]


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
