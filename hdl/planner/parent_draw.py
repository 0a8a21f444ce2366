"""Draw of a child's parents, ahead of the child."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import Unit, Width
from pathgene.hdl.protocol.planner_breeding import PARENT_DRAWS, SURVIVOR_BITS
from pathgene.hdl.protocol.random_words import LANES, WORD_BITS


__all__ = ["ParentDraw", "draw_layout"]


def draw_layout(rank_bits: int) -> data.StructLayout:
    """Return the layout of the facts from which a child is bred.

    ``head`` and ``tail`` are the ranks of its parents, ``mutation`` is the mutation word.
    """
    return data.StructLayout({"head": rank_bits, "tail": rank_bits, "mutation": WORD_BITS})


class ParentDraw(Unit):
    """Takes a step of the random source for each child, and ranks its parents.

    A parent is the best of :data:`PARENT_DRAWS` uniform draws of the selection word. A draw is
    offered 3 cycles after its words are taken; the next words are taken once it is accepted.
    Equals the draws of :func:`pathgene.sim.model.planner.breeder.breed`.

    Members
    -------
    on : In(1)
        Take words.
    words : In(stream.Signature(data.ArrayLayout(64, 2)))
        Steps of the random source: selection word, mutation word.
    survivor : Out(survivor_layout)
        ``valid``: words were taken in the previous cycle. ``bits`` select a survivor.
    draws : Out(stream.Signature(draw_layout))
    """

    rank_bits: Width(1, (WORD_BITS - SURVIVOR_BITS) // (2 * PARENT_DRAWS))

    def interface(self):
        self.survivor_layout = data.StructLayout({"valid": 1, "bits": SURVIVOR_BITS})
        return {
            "on": In(1),
            "words": In(stream.Signature(data.ArrayLayout(WORD_BITS, LANES))),
            "survivor": Out(self.survivor_layout),
            "draws": Out(stream.Signature(draw_layout(self.rank_bits))),
        }

    def elaborate(self, platform):
        m = Module()

        # Cycles since the words were taken, one bit each, until the draw is offered.
        taken = Signal()
        halved = Signal()
        busy = Signal()
        survivors_at = 2 * PARENT_DRAWS * self.rank_bits
        selection = Signal(survivors_at + SURVIVOR_BITS, reset_less=True)
        mutation = Signal(WORD_BITS, reset_less=True)
        draws = self.draws
        m.d.comb += [
            self.words.ready.eq(self.on & ~busy),
            self.survivor.valid.eq(taken),
            self.survivor.bits.eq(selection[survivors_at:]),
            draws.p.mutation.eq(mutation),
        ]
        m.d.sync += [taken.eq(self.words.valid & self.words.ready), halved.eq(taken)]
        with m.If(self.words.valid & self.words.ready):
            m.d.sync += [
                busy.eq(1),
                selection.eq(self.words.p[0]),
                mutation.eq(self.words.p[1]),
            ]
        with m.If(halved):
            m.d.sync += draws.valid.eq(1)
        with m.If(draws.valid & draws.ready):
            m.d.sync += [draws.valid.eq(0), busy.eq(0)]

        ranks = data.View(
            data.ArrayLayout(self.rank_bits, 2 * PARENT_DRAWS), selection[:survivors_at]
        )
        for parent, name in enumerate(("head", "tail")):
            pairs = []
            for pair in range(PARENT_DRAWS // 2):
                first = PARENT_DRAWS * parent + 2 * pair
                better = Signal(self.rank_bits, name=f"{name}_{pair}", reset_less=True)
                m.d.sync += better.eq(_least(ranks[first], ranks[first + 1]))
                pairs.append(better)
            best = Signal(self.rank_bits, name=f"{name}_best", reset_less=True)
            m.d.sync += best.eq(_least(*pairs))
            m.d.comb += draws.p[name].eq(best)

        return m


def _least(one, other):
    return Mux(one < other, one, other)
