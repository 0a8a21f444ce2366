"""Primitives use the platform's cells where it has suitable ones, and generic cells otherwise."""

from types import SimpleNamespace

import pytest
from amaranth import *
from amaranth.back import verilog
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.arithmetic import Multiplier
from pathgene.hdl.primitives.cells import Cells, cells_of
from pathgene.hdl.primitives.storage import BlockMemory, memory_members


class Hard(wiring.Component):
    """Component with an instance in place of a cell."""

    def __init__(self, members):
        super().__init__(members)

    def elaborate(self, platform):
        m = Module()
        m.submodules.primitive = Instance("HARD", i_clk=ClockSignal())
        return m


class Family(Cells):
    """Family with memories of even width and multipliers of up to 9 bits."""

    def memory(self, *, rows, width, ports, number):
        self.asked = (rows, width, ports, number)
        if width % 2:
            return None
        return Hard(memory_members(rows=rows, width=width, ports=ports))

    def multiplier(self, widths, signs):
        if max(widths) > 9:
            return None
        return Hard({"first": In(signed(9)), "second": In(signed(9)), "product": Out(signed(18))})


def text(component, platform=None):
    return verilog.convert(component, platform=platform, emit_src=False)


def memory(width=4, latency=2):
    return BlockMemory(rows=64, width=width, latency=latency, ports=2, number=3)


@pytest.mark.parametrize("make", [memory, lambda: Multiplier((9, 8), 3)])
def test_uses_the_cells_of_the_platform(make):
    platform = SimpleNamespace(cells=Family())
    built = text(make(), platform)
    assert built.count("HARD") == 1
    assert "always @(posedge" not in built
    if make is memory:
        assert platform.cells.asked == (64, 4, 2, 3)


@pytest.mark.parametrize(
    "make", [lambda: memory(width=3), lambda: memory(latency=1), lambda: Multiplier((9, 10))]
)
def test_uses_generic_cells_if_the_family_has_none(make):
    built = text(make(), SimpleNamespace(cells=Family()))
    assert "HARD" not in built
    assert built == text(make())


@pytest.mark.parametrize("make", [memory, lambda: Multiplier((9, 8))])
def test_uses_generic_cells_on_other_platforms(make):
    """The name of the device does not matter."""
    built = text(make(), SimpleNamespace(device="LFE5U-85F"))
    assert built == text(make())
    assert type(cells_of(None)) is Cells
