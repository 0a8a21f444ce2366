"""Parser of the order of the slots of a GENERATE."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.command.layouts import payload_members
from pathgene.hdl.layouts import ranking_layout
from pathgene.hdl.primitives.unit import Count, Unit
from pathgene.hdl.protocol.codes import Status


__all__ = ["RankingParser"]


class RankingParser(Unit):
    """Passes the order of the slots to the core, and waits until the core has applied it.

    The parser takes a byte every second cycle while the core accepts ranks. An order that is not a
    permutation of the slots is refused.

    Members
    -------
    on, repeated, bytes, ended, done, status
        See :func:`pathgene.hdl.command.layouts.payload_members`.
    identity : In(1)
        There is no payload, because the slots are already in order.
    ranking : Out(stream of rank, slot)
        The slots from the best path to the worst; registers.
    ranked : In(1)
        The core has applied the ranking.
    """

    population: Count(2, 256, "Slots.")

    def interface(self):
        self.ranking_layout = ranking_layout((self.population - 1).bit_length())
        return {
            **payload_members(),
            "identity": In(1),
            "ranking": Out(stream.Signature(self.ranking_layout)),
            "ranked": In(1),
        }

    def elaborate(self, platform):
        m = Module()
        population = self.population
        byte = self.bytes.payload
        ranking = self.ranking

        rank = Signal(range(population + 1))
        seen = Signal(population)
        too_high = Signal()
        bad_value = Signal()
        fresh = Signal()  # A slot has arrived and is not checked yet.
        complete = Signal()
        idle = Signal()
        take = Signal()
        m.d.comb += [
            complete.eq(rank == population),
            idle.eq(~fresh & ~ranking.valid),
            take.eq(self.bytes.valid & self.bytes.ready),
        ]

        def settle(status):
            m.d.comb += [self.done.eq(1), self.status.eq(status)]

        with m.If(ranking.ready):
            m.d.sync += ranking.valid.eq(0)
        m.d.sync += fresh.eq(0)
        with m.If(fresh):
            m.d.sync += [
                seen.bit_select(ranking.p.slot, 1).eq(1),
                bad_value.eq(bad_value | too_high | seen.bit_select(ranking.p.slot, 1)),
            ]
        with m.If(idle):
            m.d.sync += [
                ranking.p.rank.eq(rank),
                ranking.p.slot.eq(Mux(self.identity, rank, byte)),
                too_high.eq(byte >= population),
            ]

        with m.FSM():
            with m.State("Order"):
                with m.If(~self.on):
                    m.d.sync += [rank.eq(0), seen.eq(0), bad_value.eq(0)]
                with m.Elif(self.identity):
                    with m.If(~self.ended):
                        settle(Status.BAD_LENGTH)
                    with m.Elif(self.repeated):
                        settle(Status.OK)
                    with m.Elif(idle):
                        with m.If(complete):
                            m.next = "Ranked"
                        with m.Else():
                            m.d.sync += [rank.eq(rank + 1), ranking.valid.eq(1)]
                with m.Elif(self.ended):
                    with m.If(idle):
                        with m.If(~complete):
                            settle(Status.BAD_LENGTH)
                        with m.Elif(self.repeated):
                            settle(Status.OK)
                        with m.Elif(bad_value):
                            settle(Status.BAD_VALUE)
                        with m.Else():
                            m.next = "Ranked"
                with m.Elif(complete):
                    with m.If(self.bytes.valid & idle):  # One byte too many.
                        settle(Status.BAD_LENGTH)
                with m.Else():
                    m.d.comb += self.bytes.ready.eq(idle)
                    with m.If(take):
                        m.d.sync += [
                            rank.eq(rank + 1),
                            fresh.eq(1),
                            ranking.valid.eq(~self.repeated),
                        ]

            with m.State("Ranked"):
                with m.If(self.ranked):
                    settle(Status.OK)
                    m.next = "Order"

        return m
