"""Read index of a child, including its pending mutation."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import MutationKind
from pathgene.hdl.ga_core.chromosome import ReadIndex, pending_layout, source_layout
from pathgene.hdl.primitives.logic import one_hot_multiplex
from pathgene.hdl.primitives.unit import Count, Given, Unit


__all__ = ["ChildIndex"]


class ChildIndex(Unit):
    """Read index of a child, with its length, its middle and its pending mutation.

    Each child has an index, because its middle is not the middle of its slot and its mutation is
    applied when it is read. All paths stored in order share one index.

    Members
    -------
    advance, position, source
        See :class:`pathgene.hdl.ga_core.chromosome.ReadIndex`.
    bred_head : In(range(max_waypoints // 2 + 1))
        With ``update``: waypoints in the head of the child.
    bred_length : In(range(max_waypoints + 1))
        In the cycle before ``update``: length of the child, without its mutation.
    applied : In(len(kinds))
        In the cycle before ``update``: the mutators that changed this child, at most one.
    indices : In(range(max_waypoints)).array(len(kinds))
        With ``update``: index of the waypoint of each mutator.
    update : In(1)
        The child becomes the path that is read.
    rewrite : In(1)
        The host has replaced the path by a path of ``rewritten_length`` waypoints stored in order.
        Not with ``update``.
    rewritten_length : In(range(max_waypoints + 1))
    length : Out(range(max_waypoints + 1))
        Length of the path, including its mutation. ``min_waypoints`` after reset.
    """

    kinds: Given(
        "sequence of MutationKind",
        "Kind of each mutator, one or more; those that make a new waypoint come first.",
    )
    min_waypoints: Count(1, text="Waypoints of the shortest path.")
    max_waypoints: Count(3, text="Waypoints of the longest path.")

    def interface(self):
        self.kinds = tuple(MutationKind(kind) for kind in self.kinds)
        self.patch_count = sum(kind is not MutationKind.DELETE for kind in self.kinds)
        length = range(self.max_waypoints + 1)
        return {
            "advance": In(1),
            "position": In(range(self.max_waypoints)),
            "source": Out(source_layout(self.max_waypoints, self.patch_count)),
            "bred_head": In(range(self.max_waypoints // 2 + 1)),
            "bred_length": In(length),
            "applied": In(len(self.kinds)),
            "indices": In(range(self.max_waypoints)).array(len(self.kinds)),
            "update": In(1),
            "rewrite": In(1),
            "rewritten_length": In(length),
            "length": Out(length, init=self.min_waypoints),
        }

    def elaborate(self, platform):
        m = Module()
        head_size = self.max_waypoints // 2

        # The mutation, in the cycle of the update. At most one mutator works on a child.
        bred = Signal(pending_layout(self.max_waypoints, self.patch_count))
        applied = Signal.like(self.applied, reset_less=True)
        patches = [C(number, len(bred.patch)) for number in range(self.patch_count)]
        m.d.sync += applied.eq(self.applied)
        m.d.comb += [
            bred.at.eq(one_hot_multiplex(applied, self.indices)),
            bred.patch.eq(one_hot_multiplex(applied[: self.patch_count], patches)),
        ]
        for kind in MutationKind:
            of_kind = Cat(bit for bit, of in zip(applied, self.kinds, strict=True) if of is kind)
            m.d.comb += bred[kind.name.lower()].eq(of_kind.any())

        middle = Signal(range(head_size + 1), init=head_size)
        pending = Signal.like(bred)
        bred_length = Signal.like(self.bred_length, reset_less=True)
        m.d.sync += bred_length.eq(self.bred_length)
        with m.If(self.rewrite):
            m.d.sync += self.length.eq(self.rewritten_length)
        with m.If(self.update):
            # Adding all ones subtracts one.
            change = bred.insert | bred.delete.replicate(len(self.length))
            m.d.sync += [
                middle.eq(self.bred_head),
                self.length.eq(bred_length + change),
                pending.eq(bred),
            ]
        with m.Elif(self.rewrite):
            m.d.sync += [
                middle.eq(head_size),
                *(pending[kind.name.lower()].eq(0) for kind in MutationKind),
            ]

        m.submodules.index = index = ReadIndex(
            max_waypoints=self.max_waypoints, patch_count=self.patch_count
        )
        m.d.comb += [
            index.advance.eq(self.advance),
            index.position.eq(self.position),
            index.head.eq(middle),
            index.pending.eq(pending),
            self.source.eq(index.source),
        ]

        return m
