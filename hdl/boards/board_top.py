"""The chip between the pins of a board."""

from amaranth import *
from amaranth.lib import io
from amaranth.lib.cdc import FFSynchronizer

from pathgene.hdl.boards.board import Board
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.top import Chip


__all__ = ["BoardTop"]


class BoardTop(Unit):
    """The whole bitstream: the board's PLL, a reset, and ``Chip`` at the UART.

    The chip is held in reset until the PLL has locked, and while the board's reset pin is high;
    reset is released synchronously to the clock.
    """

    board: InstanceOf(Board)

    def interface(self):
        return {}

    def elaborate(self, platform):
        m = Module()
        board = self.board

        # All tools derive this clock's constraint from the platform's constraint on the PLL's
        # input.
        clock = Signal()
        locked = Signal()
        board.pll.connect(m, platform.request(platform.default_clk, dir="-"), clock, locked)
        m.domains.board = ClockDomain(reset_less=True)
        m.d.comb += ClockSignal("board").eq(clock)

        name, number = board.reset
        # The bridge may have more lines than these two.
        lines = {line.name: "-" for line in platform.lookup("uart", 0).ios}
        uart = platform.request("uart", 0, dir=lines)
        m.submodules.rx = rx = io.Buffer("i", uart.rx)
        m.submodules.tx = tx = io.Buffer("o", uart.tx)
        m.submodules.button = button = io.Buffer("i", platform.request(name, number, dir="-"))

        # Low after configuration, so that the chip starts in reset.
        running = Signal()
        m.submodules.running = FFSynchronizer(locked & ~button.i, running, o_domain="board")
        # The reset drives the whole chip: no logic may follow its register.
        held = Signal(init=1)
        m.d.board += held.eq(~running)

        # This name is part of every net's name, and the placer's seeds were chosen with it.
        m.submodules.planner = chip = Chip(board.config)
        m.d.comb += [
            chip.clk.eq(clock),
            chip.rst.eq(held),
            chip.rx.eq(rx.i),
            tx.o.eq(chip.tx),
        ]

        return m
