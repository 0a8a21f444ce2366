"""Adder and subtractor of the ECP5 in one carry chain, which synthesis does not find."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out


__all__ = ["Ecp5AddSubtract"]


class Ecp5AddSubtract(wiring.Component):
    """Twin of ``AddSubtract``, of the same parameter and members.

    Synthesis maps it by ``ecp5_arithmetic.v``.
    """

    def __init__(self, width):
        self.width = width
        super().__init__(
            {
                "first": In(width),
                "second": In(width),
                "subtracts": In(1),
                "total": Out(width),
            }
        )

    def elaborate(self, platform):
        m = Module()

        m.submodules.primitive = Instance(
            "ADD_OR_SUBTRACT",
            p_WIDTH=self.width,
            i_first=self.first,
            i_second=self.second,
            i_subtracts=self.subtracts,
            o_total=self.total,
        )

        return m
