"""Mapping of drawn ranks to slots, built while the ranking arrives."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from pathgene.hdl.layouts import ranking_layout
from pathgene.hdl.primitives.logic import one_hot_multiplex
from pathgene.hdl.primitives.unit import Count, Unit


__all__ = ["SlotMapping", "carrier_layout"]


def carrier_layout(population: int, max_waypoints: int) -> data.StructLayout:
    """Return the layout of the path of a read port: its slot, and its length in waypoints.

    ``select`` is ``slot`` decoded, one-hot.
    """
    return data.StructLayout(
        {"slot": range(population), "length": range(max_waypoints + 1), "select": population}
    )


class SlotMapping(Unit):
    """Assigns to each read port the slot and the length of the path of its rank.

    There are ports for the elites, whose ranks are fixed, and for the survivors and the parents.
    One word of the ranking is accepted per cycle, and takes effect 4 cycles later.

    Members
    -------
    ranking : In(stream.Signature(ranking_layout))
        Ranks in increasing order from 0, each with its slot.
    allow : In(1)
        Words of ``ranking`` are accepted, because the ranks below are complete.
    clear : In(1)
        Discard all accepted words.
    parents : In(ArrayLayout(range(population), parent_ports))
    survivors : In(ArrayLayout(range(population), survivor_ports))
        Ranks drawn.
    lengths : In(range(max_waypoints + 1)).array(population)
        Length of the path in each slot.
    carried : Out(carrier_layout).array(ports)
        Path of each port: elites, survivors, then parents.
    mapped : Out(1)
        Pulse, in the first cycle in which ``carried`` is complete.

    Attributes
    ----------
    ports : int
        Ports of all kinds.
    """

    population: Count(2, text="Slots.")
    elite_ports: Count(1)
    survivor_ports: Count(1)
    parent_ports: Count(1)
    max_waypoints: Count(3, text="Waypoints of the longest path.")

    def interface(self):
        self.ports = self.elite_ports + self.survivor_ports + self.parent_ports
        self.carrier_layout = carrier_layout(self.population, self.max_waypoints)
        rank = range(self.population)
        return {
            "ranking": In(stream.Signature(ranking_layout(ceil_log2(self.population)))),
            "allow": In(1),
            "clear": In(1),
            "parents": In(data.ArrayLayout(rank, self.parent_ports)),
            "survivors": In(data.ArrayLayout(rank, self.survivor_ports)),
            "lengths": In(range(self.max_waypoints + 1)).array(self.population),
            "carried": Out(self.carrier_layout).array(self.ports),
            "mapped": Out(1),
        }

    def elaborate(self, platform):
        m = Module()

        word = Signal.like(self.ranking.p, reset_less=True)
        taken = Signal()
        m.d.comb += self.ranking.ready.eq(self.allow)
        m.d.sync += [
            word.eq(self.ranking.p),
            taken.eq(self.ranking.valid & self.ranking.ready),
        ]

        # Each port compares the halves of a rank while the word is accepted, combines the results
        # while the slot is decoded, and takes the word in the cycle after its length is looked up.
        slot = Signal.like(word.slot, reset_less=True)
        select = Signal(self.population, reset_less=True)
        found = Signal(self.carrier_layout, reset_less=True)
        last, final = Signal(), Signal()
        m.d.sync += [
            slot.eq(word.slot),
            select.eq(1 << word.slot),
            found.slot.eq(slot),
            found.select.eq(select),
            found.length.eq(one_hot_multiplex(select, self.lengths)),
            last.eq(taken & (word.rank == self.population - 1) & ~self.clear),
            final.eq(last & ~self.clear),
            self.mapped.eq(final & ~self.clear),
        ]
        ranks = [*range(self.elite_ports), *self.survivors, *self.parents]
        half = len(word.rank) // 2
        for number, rank in enumerate(ranks):
            rank = C(rank, len(word.rank)) if isinstance(rank, int) else rank
            low = Signal(name=f"low_{number}", reset_less=True)
            high = Signal(name=f"high_{number}", reset_less=True)
            equal = Signal(name=f"equal_{number}")
            hit = Signal(name=f"hit_{number}")
            m.d.sync += [
                low.eq(self.ranking.p.rank[:half] == rank[:half]),
                high.eq(self.ranking.p.rank[half:] == rank[half:]),
                equal.eq(taken & low & high),
                hit.eq(equal),
            ]
            carried = Signal(self.carrier_layout, name=f"port_{number}", reset_less=True)
            m.d.comb += self.carried[number].eq(carried)
            with m.If(hit):
                m.d.sync += carried.eq(found)

        return m
