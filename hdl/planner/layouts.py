"""Payloads of the streams between the units of the planner."""

from amaranth.hdl import signed
from amaranth.lib import data
from amaranth.utils import exact_log2

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import BASE_BITS, BEND_BITS, EDGE_BITS, EDGES, problem_request


__all__ = ["problem_layout", "row_layout", "shape_layout"]


def problem_layout(config: Config) -> data.StructLayout:
    """Return the layout of a problem's record: the request's, but ``base`` with its sign."""
    fields = dict(problem_request(config).fields)
    assert fields["base"] == BASE_BITS
    return data.StructLayout({**fields, "base": signed(BASE_BITS)})


def row_layout(lanes: int, coordinate_bits: int) -> data.StructLayout:
    """Return the layout of a row of ``lanes`` corners.

    ``x``: coordinate of the first corner, divided by ``lanes``, which is a power of two. ``y``.
    """
    return data.StructLayout({"x": coordinate_bits - exact_log2(lanes), "y": coordinate_bits})


def shape_layout(coordinate_bits: int) -> data.StructLayout:
    """Return the layout of corners that become blocked: the request's, but edges with their signs.

    See :func:`pathgene.hdl.protocol.planner.no_fly_request`.
    """
    fields = dict.fromkeys(("first_x", "first_y", "last_x", "last_y"), coordinate_bits)
    fields |= {"bend_x": BEND_BITS, "bend_y": BEND_BITS}
    for edge in range(EDGES):
        fields |= {
            f"at_{edge}": signed(coordinate_bits + EDGE_BITS + 1),
            f"east_{edge}": signed(EDGE_BITS),
            f"north_{edge}": signed(EDGE_BITS),
        }
    return data.StructLayout(fields)
