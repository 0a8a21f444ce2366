"""Limits of a run and of an island: cycles and generations."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import Unit, Width


__all__ = ["RunLimits"]


class RunLimits(Unit):
    """Counts the cycles and generations of a run, and says when to breed no further one.

    ``split`` takes an island's part: ``share / 2**share_bits`` of the cycles that are left, and of
    the generations of the run, rounded down. ``aim`` sets the limits of the run, or the limits of
    an island: the present numbers plus its parts, clamped to the maximum count.

    Members
    -------
    launch : In(1)
        Pulse: a run begins in the next cycle, which is cycle 0.
    running : In(1)
        From that cycle to the last one of the run.
    bred : In(1)
        Pulse: a generation is bred.
    stop : In(1)
        Pulse: breed no further generation. Ignored unless ``running``.
    most_cycles, most_generations : In(counter_bits)
    share : In(share_bits)
        Limits of the run, and the share of an island. Steady while ``running``.
    split : In(1)
        Pulse: take an island's part of the cycles that are left after this one.
    splitting : Out(1)
        For ``share_bits`` cycles, starting in the one after ``split``.
    aim : In(1)
        Pulse: set limits, starting in the next cycle. Not while ``splitting``.
    waits : In(1)
        The limit of generations does not count yet.
    final : In(1)
        With ``aim``: set the limits of the run, else the numbers of this cycle plus the island's
        parts.
    reached : Out(1)
        In the previous cycle, a limit was reached, or the run had been stopped.
    cycles : Out(counter_bits)
        Number of this cycle; afterwards, cycles of the run. Saturates.
    generations : Out(counter_bits)
        Generations bred before this cycle.
    """

    counter_bits: Width(1)
    share_bits: Width(1)

    def interface(self):
        return {
            "launch": In(1),
            "running": In(1),
            "bred": In(1),
            "stop": In(1),
            "most_cycles": In(self.counter_bits),
            "most_generations": In(self.counter_bits),
            "share": In(self.share_bits),
            "split": In(1),
            "splitting": Out(1),
            "aim": In(1),
            "waits": In(1),
            "final": In(1),
            "reached": Out(1),
            "cycles": Out(self.counter_bits),
            "generations": Out(self.counter_bits),
        }

    def elaborate(self, platform):
        m = Module()

        stopped = Signal()
        with m.If(self.running):
            m.d.sync += [
                self.cycles.eq(self.cycles + ~self.cycles.all()),
                self.generations.eq(self.generations + self.bred),
                stopped.eq(stopped | self.stop),
            ]
        with m.If(self.launch):
            m.d.sync += [self.cycles.eq(0), self.generations.eq(0), stopped.eq(0)]

        # A part is a product with the share, a bit of it per cycle, the lowest first.
        bits = self.counter_bits
        left = Signal(bits, reset_less=True)
        difference = Signal(bits + 1)
        share = Signal(self.share_bits, reset_less=True)
        number = Signal(range(self.share_bits + 1))
        m.d.comb += [
            difference.eq(self.most_cycles - self.cycles),
            self.splitting.eq(number != 0),
        ]
        parts = []
        for name, whole in (("cycles", left), ("generations", self.most_generations)):
            part = Signal(bits, name=f"part_of_{name}", reset_less=True)
            with m.If(self.splitting):
                m.d.sync += part.eq((part + Mux(share[0], whole, 0)) >> 1)
            with m.If(self.split):
                m.d.sync += part.eq(0)
            parts.append(part)
        with m.If(self.splitting):
            m.d.sync += [number.eq(number - 1), share.eq(share >> 1)]
        with m.If(self.split):
            m.d.sync += [
                left.eq(Mux(difference[-1], 0, difference)),
                share.eq(self.share),
                number.eq(self.share_bits),
            ]

        limits = []
        for name, count, part, most in (
            ("cycles", self.cycles, parts[0], self.most_cycles),
            ("generations", self.generations, parts[1], self.most_generations),
        ):
            limit = Signal(bits, name=f"limit_of_{name}", reset_less=True)
            end = Signal(bits + 1, name=f"end_of_{name}")
            m.d.comb += end.eq(count + part)
            with m.If(self.aim):
                m.d.sync += limit.eq(Mux(self.final, most, end | end[-1].replicate(len(end))))
            limits.append(limit)
        m.d.sync += self.reached.eq(
            stopped | (self.cycles >= limits[0]) | ((self.generations >= limits[1]) & ~self.waits)
        )

        return m
