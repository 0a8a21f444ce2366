"""Turns the ranks drawn by the selection unit into slots while the ranking comes in."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config
from hdl.layouts import ranking_layout
from hdl.primitives.multiplexer import one_hot_multiplex


__all__ = ["SlotMapping", "carrier_layout", "carriers"]


def carriers(config: Config) -> int:
    """Return how many paths are read at once: elites, survivors, then crossover parents."""
    return config.elites + config.survivors + config.crossovers


def carrier_layout(config: Config) -> data.StructLayout:
    """Return the layout of what a read port carries: the path of ``slot``, ``length`` waypoints.

    ``select`` is ``slot`` decoded: the bit of that number alone is set.
    """
    return data.StructLayout(
        {"slot": config.slot_bits, "length": config.length_bits, "select": config.population}
    )


class SlotMapping(wiring.Component):
    """Gives each read port the slot and the length of the path whose rank it has.

    The ports are those of the elites, whose ranks are fixed, of the survivors and of the parents. A
    word of the ranking is worked in 4 clocks after it is taken, one a clock; nothing is left to do
    when a generation starts.

    Parameters
    ----------
    config : Config

    Members
    -------
    ranking : In(stream.Signature(ranking_layout))
        Ranks upwards from 0, each with its slot.
    allow : In(1)
        Whether ``ranking`` is taken: the ranks below are complete.
    clear : In(1)
        What has been worked in is void.
    parents : In(ArrayLayout(slot_bits, crossovers))
    survivors : In(ArrayLayout(slot_bits, survivors))
        Ranks drawn.
    lengths : In(length_bits).array(population)
        Length of the path in each slot.
    carried : Out(carrier_layout).array(carriers)
    mapped : Out(1)
        Pulse, in the first clock in which ``carried`` is complete.
    """

    def __init__(self, config):
        self.config = config
        super().__init__(
            {
                "ranking": In(stream.Signature(ranking_layout(config.slot_bits))),
                "allow": In(1),
                "clear": In(1),
                "parents": In(data.ArrayLayout(config.slot_bits, config.crossovers)),
                "survivors": In(data.ArrayLayout(config.slot_bits, config.survivors)),
                "lengths": In(config.length_bits).array(config.population),
                "carried": Out(carrier_layout(config)).array(carriers(config)),
                "mapped": Out(1),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config

        word = Signal(ranking_layout(config.slot_bits), reset_less=True)
        taken = Signal()
        m.d.comb += self.ranking.ready.eq(self.allow)
        m.d.sync += [
            word.eq(self.ranking.p),
            taken.eq(self.ranking.valid & self.ranking.ready),
        ]

        # Each port compares the halves of a rank while the word is taken, looks at both results
        # while the slot is decoded, and takes the word in the clock after its length is looked up.
        slot = Signal.like(word.slot, reset_less=True)
        select = Signal(config.population, reset_less=True)
        found = Signal(carrier_layout(config), reset_less=True)
        last, final = Signal(), Signal()
        m.d.sync += [
            slot.eq(word.slot),
            select.eq(1 << word.slot),
            found.slot.eq(slot),
            found.select.eq(select),
            found.length.eq(one_hot_multiplex(select, self.lengths)),
            last.eq(taken & (word.rank == config.population - 1) & ~self.clear),
            final.eq(last & ~self.clear),
            self.mapped.eq(final & ~self.clear),
        ]
        ranks = [*range(config.elites), *self.survivors, *self.parents]
        half = config.slot_bits // 2
        for number, rank in enumerate(ranks):
            rank = C(rank, config.slot_bits) if isinstance(rank, int) else rank
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
            carried = Signal(carrier_layout(config), name=f"port_{number}", reset_less=True)
            m.d.comb += self.carried[number].eq(carried)
            with m.If(hit):
                m.d.sync += carried.eq(found)

        return m
