"""Cycles of the drawer of shapes, as the gateware takes them."""

from __future__ import annotations

from hdl.protocol.planner import NoFlyShape


__all__ = ["drawing"]


def drawing(shape: NoFlyShape) -> int:
    """Return the cycles in which a shape is offered, up to that in which it is taken."""
    return (shape.last_x - shape.first_x + 1) * (shape.last_y - shape.first_y + 1) + 2
