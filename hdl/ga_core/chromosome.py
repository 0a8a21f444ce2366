"""Chromosome: the waypoints of a slot, and the read indices of stored paths and of children."""

from amaranth import *
from amaranth.lib import data, memory, wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import MutationKind
from pathgene.hdl.primitives.logic import multiplex, one_hot_multiplex
from pathgene.hdl.primitives.unit import Count, Given, Unit, Width


__all__ = [
    "ChildIndex",
    "Chromosome",
    "ReadIndex",
    "half_signature",
    "pending_layout",
    "place_shape",
    "source_layout",
]


def place_shape(max_waypoints: int) -> Shape:
    """Return the shape of a waypoint's place in its half of a chromosome.

    If the halves differ, the tail is the longer one.
    """
    return Shape.cast(range(max_waypoints - max_waypoints // 2))


def half_signature(waypoint_bits: int, max_waypoints: int) -> wiring.Signature:
    """Return the signature of a write to one half: enable, place and waypoint."""
    return wiring.Signature(
        {
            "valid": Out(1),
            "at": Out(place_shape(max_waypoints)),
            "waypoint": Out(waypoint_bits),
        }
    )


def pending_layout(max_waypoints: int, patch_count: int) -> data.StructLayout:
    """Return the layout of a mutation that is applied when the path is read.

    ``perturb``, ``insert`` and ``delete``: one or none is set. ``at`` is the index of the
    waypoint that is moved or removed, or after which a waypoint is added; ``patch`` is the number
    of the new waypoint.
    """
    return data.StructLayout(
        {
            "perturb": 1,
            "insert": 1,
            "delete": 1,
            "patch": range(patch_count),
            "at": range(max_waypoints),
        }
    )


def source_layout(max_waypoints: int, patch_count: int) -> data.StructLayout:
    """Return the layout of a waypoint's source: a patch, or place ``at`` in one of the halves.

    Exactly one bit of ``patches``, ``head`` and ``tail`` together is set.
    """
    return data.StructLayout(
        {"patches": patch_count, "head": 1, "tail": 1, "at": place_shape(max_waypoints)}
    )


class ReadIndex(Unit):
    """Finds the source of each waypoint of a path. A pending mutation only changes the source.

    ``source`` belongs to the ``position`` of the latest cycle with ``advance``, and to ``head`` and
    ``pending`` of the previous cycle. It is undefined for positions past the end of the path.

    Members
    -------
    advance : In(1)
    position : In(range(max_waypoints))
    head : In(range(max_waypoints // 2 + 1))
        Number of waypoints in the head; the rest is in the tail.
    pending : In(pending_layout)
    source : Out(source_layout)
    """

    max_waypoints: Count(3, text="Waypoints of the longest path.")
    patch_count: Count(1, text="New waypoints of the children.")

    def interface(self):
        return {
            "advance": In(1),
            "position": In(range(self.max_waypoints)),
            "head": In(range(self.max_waypoints // 2 + 1)),
            "pending": In(pending_layout(self.max_waypoints, self.patch_count)),
            "source": Out(source_layout(self.max_waypoints, self.patch_count)),
        }

    def elaborate(self, platform):
        m = Module()
        position, pending = self.position, self.pending
        head_size = self.max_waypoints // 2
        place = place_shape(self.max_waypoints)

        # A mutation does not change the waypoints before `mark`. At `mark` there is the patch, or
        # the index is shifted by one from there on. The tail begins at `start`, which is shifted
        # too if the mutation is in the head.
        mark = Signal(range(self.max_waypoints), reset_less=True)
        start = Signal(range(head_size + 2), init=head_size, reset_less=True)
        patches = Signal(self.patch_count, reset_less=True)
        shifts = Signal(reset_less=True)
        shifts_tail = Signal()
        m.d.comb += shifts_tail.eq((pending.insert | pending.delete) & (pending.at < self.head))
        m.d.sync += [
            mark.eq(pending.at + pending.insert),
            start.eq(
                Mux(shifts_tail, Mux(pending.insert, self.head + 1, self.head - 1), self.head)
            ),
            patches.eq(Mux(pending.perturb | pending.insert, 1 << pending.patch, 0)),
            shifts.eq(pending.insert | pending.delete),
        ]

        # Places are positions minus the start of a half: 0 or the middle, each shifted or not. All
        # four are computed before it is known which one applies.
        middle = Signal(place, reset_less=True)
        shifted_middle = Signal.like(middle, reset_less=True)
        shifted_start = Signal.like(middle, reset_less=True)
        m.d.sync += [
            middle.eq(self.head),
            shifted_middle.eq(Mux(pending.insert, self.head + 1, self.head - 1)),
            shifted_start.eq(Mux(pending.insert, 1, -1)),
        ]
        patched = Signal(self.patch_count)
        shifted = Signal()
        tail = Signal()
        places = [
            Signal(place, name=name)
            for name in ("in_head", "in_tail", "in_shifted_head", "in_shifted_tail")
        ]
        m.d.comb += [
            patched.eq(patches & (position == mark).replicate(self.patch_count)),
            shifted.eq(shifts & (position >= mark)),
            tail.eq(position >= start),
            *(
                found.eq(position - base)
                for found, base in zip(
                    places, (C(0), middle, shifted_start, shifted_middle), strict=True
                )
            ),
        ]

        source = Signal.like(self.source, reset_less=True)
        m.d.comb += self.source.eq(source)
        with m.If(self.advance):
            m.d.sync += [
                source.patches.eq(patched),
                source.head.eq(~tail & ~patched.any()),
                source.tail.eq(tail & ~patched.any()),
                source.at.eq(multiplex(Cat(tail, shifted), places)),
            ]

        return m


class Chromosome(Unit):
    """Stores the waypoints of one slot in two halves of two banks each: LUT RAM on the target.

    While one bank is read, the second can be written, both halves at once. ``waypoint`` belongs to
    the ``source`` of the latest cycle with ``advance``. A write in the same cycle is not visible.

    The memories are zero when the chip is configured; a later reset does not change them.

    Members
    -------
    advance : In(1)
    bank : In(1)
        The bank to read.
    source : In(source_layout)
    patches : In(waypoint_bits).array(patch_count)
        New waypoints.
    waypoint : Out(waypoint_bits)
    written : In(1)
        The bank to write.
    head, tail : In(half_signature)
        Writes to the halves.
    """

    waypoint_bits: Width(1)
    max_waypoints: Count(3, text="Waypoints of the longest path.")
    patch_count: Count(1, text="New waypoints of the children.")

    def interface(self):
        return {
            "advance": In(1),
            "bank": In(1),
            "source": In(source_layout(self.max_waypoints, self.patch_count)),
            "patches": In(self.waypoint_bits).array(self.patch_count),
            "waypoint": Out(self.waypoint_bits),
            "written": In(1),
            "head": In(half_signature(self.waypoint_bits, self.max_waypoints)),
            "tail": In(half_signature(self.waypoint_bits, self.max_waypoints)),
        }

    def elaborate(self, platform):
        m = Module()

        read = {}
        for name, write in (("head", self.head), ("tail", self.tail)):
            m.submodules[name] = half = memory.Memory(
                shape=self.waypoint_bits,
                depth=2 << place_shape(self.max_waypoints).width,
                init=[],
            )
            write_port = half.write_port()
            read_port = half.read_port(domain="comb")
            m.d.comb += [
                write_port.en.eq(write.valid),
                write_port.addr.eq(Cat(write.at, self.written)),
                write_port.data.eq(write.waypoint),
                read_port.addr.eq(Cat(self.source.at, self.bank)),
            ]
            read[name] = read_port.data

        waypoint = Signal(self.waypoint_bits, reset_less=True)
        m.d.comb += self.waypoint.eq(waypoint)
        with m.If(self.advance):
            select = Cat(self.source.head, self.source.tail, self.source.patches)
            m.d.sync += waypoint.eq(
                one_hot_multiplex(select, [read["head"], read["tail"], *self.patches])
            )

        return m


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
