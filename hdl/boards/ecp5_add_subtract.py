"""Adder and subtractor of the ECP5 in one carry chain, which synthesis does not find."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import Unit, Width


__all__ = ["Ecp5AddSubtract"]


class Ecp5AddSubtract(Unit):
    """Twin of ``AddSubtract``, of the same parameter and members.

    Synthesis maps it by ``ecp5_arithmetic.v``.
    """

    width: Width(1)

    def interface(self):
        return {
            "first": In(self.width),
            "second": In(self.width),
            "subtracts": In(1),
            "total": Out(self.width),
        }

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
