"""Assignments to many signals at once."""

from collections.abc import Iterable

from amaranth.hdl import Value


__all__ = ["assign_each"]


def assign_each(targets: Iterable[Value], sources: Iterable[Value]) -> list:
    """Return the assignments of each of ``sources`` to its target; there are as many of both."""
    return [target.eq(source) for target, source in zip(targets, sources, strict=True)]
