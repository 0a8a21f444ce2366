"""One slot of the population: two small memories, and the index that reads them as one path."""

from amaranth import *
from amaranth.lib import data, memory, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from hdl.config import Config
from hdl.primitives.multiplexer import multiplex, one_hot_multiplex


__all__ = [
    "Chromosome",
    "ReadIndex",
    "half_bits",
    "half_signature",
    "pending_layout",
    "position_bits",
    "source_layout",
]


def half_bits(config: Config) -> int:
    """Return the width of the position of a waypoint in its half of a chromosome."""
    return ceil_log2(config.tail_size)


def position_bits(config: Config) -> int:
    """Return the width of a position that lock-step reading counts: two past the longest path."""
    return (config.max_waypoints + 2).bit_length()


def half_signature(config: Config) -> wiring.Signature:
    """Return the signature of a write to one half: whether, where, what."""
    return wiring.Signature(
        {
            "valid": Out(1),
            "at": Out(half_bits(config)),
            "waypoint": Out(config.waypoint_bits),
        }
    )


def pending_layout(config: Config) -> data.StructLayout:
    """Return the layout of a mutation that is made when the path is read: at most one is set.

    ``at`` is the waypoint moved, removed, or after which one is added; ``patch`` the number of the
    new waypoint.
    """
    return data.StructLayout(
        {
            "perturb": 1,
            "insert": 1,
            "delete": 1,
            "patch": range(config.patches),
            "at": config.index_bits,
        }
    )


def source_layout(config: Config) -> data.StructLayout:
    """Return the layout of where a waypoint is read: a patch, or place ``at`` in one of the halves.

    One bit is set of ``patches``, ``head`` and ``tail`` together.
    """
    return data.StructLayout(
        {"patches": config.patches, "head": 1, "tail": 1, "at": half_bits(config)}
    )


class ReadIndex(wiring.Component):
    """Says where each waypoint of a path lies: a pending mutation changes the index, not the path.

    ``source`` belongs to the ``position`` of the latest clock with ``advance``, and to ``head`` and
    ``pending`` of a clock before that. What it says about positions past the end of the path means
    nothing.

    Parameters
    ----------
    config : Config

    Members
    -------
    advance : In(1)
    position : In(index_bits)
    head : In(range(head_size + 1))
        Waypoints in the head; those after them lie in the tail.
    pending : In(pending_layout)
    source : Out(source_layout)
    """

    def __init__(self, config):
        self.config = config
        super().__init__(
            {
                "advance": In(1),
                "position": In(config.index_bits),
                "head": In(range(config.head_size + 1)),
                "pending": In(pending_layout(config)),
                "source": Out(source_layout(config)),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config, position, pending = self.config, self.position, self.pending

        # A path with a mutation goes on as it is up to `mark`: there is the patch, or from there on
        # the index is one on or back. The tail begins at `start`, and that is one off, too, where
        # the mutation is in the head.
        mark = Signal(config.index_bits, reset_less=True)
        start = Signal(range(config.head_size + 2), init=config.head_size, reset_less=True)
        patches = Signal(config.patches, reset_less=True)
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

        # Where the tail begins in the path, and what one of the index less or more makes of that
        # and of 0; then all that the place may be, before it is known which it is.
        middle = Signal(half_bits(config), reset_less=True)
        shifted_middle = Signal.like(middle, reset_less=True)
        shifted_start = Signal.like(middle, reset_less=True)
        m.d.sync += [
            middle.eq(self.head),
            shifted_middle.eq(Mux(pending.insert, self.head + 1, self.head - 1)),
            shifted_start.eq(Mux(pending.insert, 1, -1)),
        ]
        patched = Signal(config.patches)
        shifted = Signal()
        tail = Signal()
        places = [
            Signal(half_bits(config), name=name)
            for name in ("in_head", "in_tail", "in_shifted_head", "in_shifted_tail")
        ]
        m.d.comb += [
            patched.eq(patches & (position == mark).replicate(config.patches)),
            shifted.eq(shifts & (position >= mark)),
            tail.eq(position >= start),
            *(
                place.eq(position - base)
                for place, base in zip(
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


class Chromosome(wiring.Component):
    """Waypoints of one slot, in two halves of two banks each: LUT RAM on the target.

    While one bank is read, the other can be written, both halves at once. ``waypoint`` belongs to
    the ``source`` of the latest clock with ``advance``; it does not see a write of the same clock.

    The memories are zero when the chip is configured; a later reset leaves them alone.

    Parameters
    ----------
    config : Config

    Members
    -------
    advance : In(1)
    bank : In(1)
        The bank read.
    source : In(source_layout)
    patches : In(waypoint_bits).array(patches)
        New waypoints.
    waypoint : Out(waypoint_bits)
    written : In(1)
        The bank written.
    head, tail : In(half_signature)
        Writes to the halves.
    """

    def __init__(self, config):
        self.config = config
        super().__init__(
            {
                "advance": In(1),
                "bank": In(1),
                "source": In(source_layout(config)),
                "patches": In(config.waypoint_bits).array(config.patches),
                "waypoint": Out(config.waypoint_bits),
                "written": In(1),
                "head": In(half_signature(config)),
                "tail": In(half_signature(config)),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config

        read = {}
        for name, write in (("head", self.head), ("tail", self.tail)):
            m.submodules[name] = half = memory.Memory(
                shape=config.waypoint_bits, depth=2 << half_bits(config), init=[]
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

        waypoint = Signal(config.waypoint_bits, reset_less=True)
        m.d.comb += self.waypoint.eq(waypoint)
        with m.If(self.advance):
            select = Cat(self.source.head, self.source.tail, self.source.patches)
            m.d.sync += waypoint.eq(
                one_hot_multiplex(select, [read["head"], read["tail"], *self.patches])
            )

        return m
