"""Plan of a child: its parents, drawn ahead, the source of its waypoints, and its mutation."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import Config
from pathgene.hdl.planner.layouts import path_layout
from pathgene.hdl.primitives.arithmetic import Multiplier
from pathgene.hdl.primitives.unit import Count, Unit, Width
from pathgene.hdl.protocol.breeding import (
    CUT,
    DELETE,
    INSERT,
    MUTATIONS,
    OFFSETS,
    OPERATOR,
    PARENT_DRAWS,
    PLACE,
    SETTLE,
    SIZE,
    SURVIVOR_BITS,
)
from pathgene.hdl.protocol.random_words import LANES, WORD_BITS


__all__ = ["ChildPlanner", "ParentDraw", "draw_layout", "plan_layout"]


def draw_layout(rank_bits: int) -> data.StructLayout:
    """Return the layout of the data from which a child is bred.

    ``head`` and ``tail`` are the ranks of its parents, ``mutation`` is the mutation word.
    """
    return data.StructLayout({"head": rank_bits, "tail": rank_bits, "mutation": WORD_BITS})


class ParentDraw(Unit):
    """Takes a step of the random source for each child, and draws the ranks of its parents.

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

        # Cycles since the words were taken, one bit per cycle, until the draw is offered.
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


_FIRST_OFFSET, _OFFSET_BITS = OFFSETS
_AXES = ("x", "y", "altitude")


def plan_layout(slot_bits, max_waypoints, box_cells, box_steps):
    """Return the layout of the plan of a child.

    ``head_slot``, ``tail_slot`` : its parents. ``head`` : number of waypoints from the first
    parent, before its cut. ``tail_gain`` : index of a tail waypoint in the second parent minus its
    index in the child before the mutation. ``length`` : number of waypoints before the mutation.

    ``inserts``, ``deletes``, ``settles``, of which at most one is set; if none is, the mutation
    moves a waypoint. ``place`` : the waypoint, counted from 1 because the start is point 0, or the
    point before which one is inserted. ``move`` : displacement of a moved waypoint. ``doubles`` : a
    settled waypoint descends by half its margin, doubled this number of times.
    """
    length = range(max_waypoints + 1)
    most = max_waypoints * 7 // 8
    return data.StructLayout(
        {
            "head_slot": slot_bits,
            "tail_slot": slot_bits,
            "head": range(most + 1),
            "tail_gain": range(-most, most + 1),
            "length": length,
            "inserts": 1,
            "deletes": 1,
            "settles": 1,
            "place": range(max_waypoints + 2),
            "move": data.StructLayout(
                {
                    "x": range(-box_cells, box_cells + 1),
                    "y": range(-box_cells, box_cells + 1),
                    "altitude": range(-box_steps, box_steps + 1),
                }
            ),
            "doubles": 2,
        }
    )


class ChildPlanner(Unit):
    """Looks up the parents of a child, and decodes its mutation.

    The first parent is read in the first cycle of a draw, the second parent in the next cycle, and
    the plan is offered 8 cycles after the first parent. The next draw begins in the cycle in which
    the plan is taken, so plans follow each other every 8 cycles. Equals ``cross`` and ``mutate`` of
    :mod:`pathgene.sim.model.planner.breeder`, except for the waypoints.

    Members
    -------
    draws : In(stream.Signature(draw_layout))
    rank : Out(rank_bits)
        Member to read.
    parent : In(path_layout)
        Slot and length of the member at the previous cycle's ``rank``.
    plans : Out(stream.Signature(plan_layout))
    """

    rank_bits: Width(1, 5)
    slot_bits: Width(1)
    max_waypoints: Count(3, text="Waypoints of the longest path.")
    box_cells: Count(1, text="Maximum gain of a moved waypoint in x and in y.", name="Box width")
    box_steps: Count(1, text="Maximum gain of a moved waypoint in altitude.", name="Box height")

    def interface(self):
        self.plan_layout = plan_layout(
            self.slot_bits, self.max_waypoints, self.box_cells, self.box_steps
        )
        self.parent_layout = path_layout(self.slot_bits, self.max_waypoints.bit_length())
        return {
            "draws": In(stream.Signature(draw_layout(self.rank_bits))),
            "rank": Out(self.rank_bits),
            "parent": In(self.parent_layout),
            "plans": Out(stream.Signature(self.plan_layout)),
        }

    def elaborate(self, platform):
        m = Module()

        # A step of a plan takes one cycle. `second` : the tail's parent is read; each bit of
        # `passed` is set one cycle after the bit below it.
        second = Signal()
        busy = Signal()
        passed = Signal(6)
        reads = Signal()
        accepted = Signal()
        draw = self.draws.p
        m.d.comb += [
            # The first parent of the next child is read while this child's plan is taken.
            reads.eq(self.draws.valid & (~busy | (self.plans.valid & self.plans.ready))),
            self.rank.eq(Mux(second, draw.tail, draw.head)),
            accepted.eq(reads & second),
            self.draws.ready.eq(accepted),
        ]
        with m.If(reads):
            m.d.sync += second.eq(~second)
        m.d.sync += passed.eq(Cat(accepted, passed))
        with m.If(self.plans.valid & self.plans.ready):
            m.d.sync += [self.plans.valid.eq(0), busy.eq(0)]
        with m.If(accepted):
            m.d.sync += busy.eq(1)
        with m.If(passed[-1]):
            m.d.sync += self.plans.valid.eq(1)

        plan = Signal(self.plan_layout, reset_less=True)
        m.d.comb += self.plans.p.eq(plan)
        self._cross(m, plan, second, passed)
        self._mutate(m, plan, accepted, passed)

        return m

    def _cross(self, m, plan, second, passed):
        """Measure the child, starting in the cycles in which the parents arrive."""
        parent = self.parent
        # The length of the second parent, and its waypoints before the tail.
        whole = Signal(range(self.max_waypoints + 1), reset_less=True)
        tail_before = Signal(plan.head.shape(), reset_less=True)
        # For each parent, the waypoints before its cut, after 1, 3, 5 or 7 eighths of its length:
        # computed by sums, because a multiplier would be far away. The draw stays while the parents
        # are read.
        cut = Signal(2, reset_less=True)
        before = Signal(plan.head.shape())
        length = parent.length
        m.d.sync += cut.eq(_bits(self.draws.p.mutation, CUT))
        m.d.comb += before.eq(
            (length + Mux(cut[0], length << 1, 0) + Mux(cut[1], length << 2, 0)) >> 3
        )
        with m.If(second):
            m.d.sync += [plan.head_slot.eq(parent.slot), plan.head.eq(before)]
        with m.If(passed[0]):
            m.d.sync += [
                plan.tail_slot.eq(parent.slot),
                tail_before.eq(before),
                whole.eq(parent.length),
            ]
        m.d.sync += [
            plan.length.eq(whole + plan.head - tail_before),
            plan.tail_gain.eq(tail_before - plan.head),
        ]

    def _mutate(self, m, plan, accepted, passed):
        """Decode the mutation; the length is known by the third cycle after the draw."""
        word = self.draws.p.mutation
        operator = _bits(word, OPERATOR)
        size = Signal(4, reset_less=True)
        place = Signal(8, reset_less=True)
        would_insert, would_delete = (
            Signal(name=f"would_{name}", reset_less=True) for name in ("insert", "delete")
        )
        with m.If(accepted):
            m.d.sync += [
                size.eq(_bits(word, SIZE)),
                place.eq(_bits(word, PLACE)),
                would_insert.eq((operator >= _first(INSERT)) & (operator < _first(DELETE))),
                would_delete.eq((operator >= _first(DELETE)) & (operator < _first(SETTLE))),
                plan.settles.eq(operator >= _first(SETTLE)),
            ]

        # Free-running: the inputs are steady, so each cycle repeats the previous results.
        shift = Signal(3, reset_less=True)
        choices = Signal(range(self.max_waypoints + 2), reset_less=True)
        m.submodules.place_product = product = Multiplier((len(place) + 1, len(choices) + 1), 8)
        m.d.sync += [
            plan.inserts.eq(would_insert & (plan.length != self.max_waypoints)),
            plan.deletes.eq(would_delete & (plan.length != Config.MIN_WAYPOINTS)),
            choices.eq(plan.length + plan.inserts),
            plan.doubles.eq(size * 3 >> 4),
            shift.eq(Mux(plan.inserts, size * 7 >> 4, size >> 1)),
            plan.place.eq(product.product + 1),
        ]
        m.d.comb += [product.first.eq(place), product.second.eq(choices)]

        for number, axis in enumerate(_AXES):
            box = self.box_steps if axis == "altitude" else self.box_cells
            bits = Signal(_OFFSET_BITS, name=f"bits_{axis}", reset_less=True)
            low = _FIRST_OFFSET + number * _OFFSET_BITS
            with m.If(accepted):
                m.d.sync += bits.eq(word[low : low + _OFFSET_BITS])
            factor = 2 * box + 1
            scaled = Multiplier((_OFFSET_BITS + 1, factor.bit_length() + 1), _OFFSET_BITS)
            m.submodules[f"scaled_{axis}"] = scaled
            offset = Signal(range(-box, box + 1), name=f"offset_{axis}", reset_less=True)
            m.d.comb += [scaled.first.eq(bits), scaled.second.eq(factor)]
            m.d.sync += [
                offset.eq(scaled.product - box),
                plan.move[axis].eq(offset >> shift),
            ]


def _bits(word, place):
    """Return the bits of a word at a place, given as first bit and width."""
    first, width = place
    return word[first : first + width]


def _first(number):
    """Return the smallest of the 256 draw values that selects this mutation or a later one."""
    return -(-number * 256 // MUTATIONS)
