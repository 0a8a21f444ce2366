"""One slot of the population: two small memories, and the index that reads them as one path."""

from amaranth import *
from amaranth.lib import data, memory, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from hdl.config import Config
from hdl.ga_core.multiplexer import chosen


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
    """Return the layout of where a waypoint is read: a patch, or a place in one of the halves."""
    return data.StructLayout(
        {"patched": 1, "patch": range(config.patches), "tail": 1, "at": half_bits(config)}
    )


class ReadIndex(wiring.Component):
    """Says where each waypoint of a path lies: a pending mutation changes the index, not the path.

    ``source`` belongs to the ``position`` of the latest clock with ``advance``. What it says about
    positions past the end of the path means nothing.

    Parameters
    ----------
    config : Config

    Members
    -------
    advance : In(1)
    position : In(position_bits)
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
                "position": In(position_bits(config)),
                "head": In(range(config.head_size + 1)),
                "pending": In(pending_layout(config)),
                "source": Out(source_layout(config)),
            }
        )

    def elaborate(self, platform):
        m = Module()
        position, pending = self.position, self.pending

        past = Signal()
        here = Signal()
        back = Signal()
        on = Signal()
        m.d.comb += [
            past.eq(position > pending.at),
            here.eq(position == pending.at),
            back.eq(pending.insert & past),
            on.eq(pending.delete & (past | here)),
        ]

        # The index is `position`, or one back or on. One subtraction tells where all three lie, and
        # a step of one in so few bits needs no carry chain: one behind the other would be too slow.
        beyond = Signal(signed(len(position) + 1))
        tail = Signal()
        m.d.comb += [
            beyond.eq(position - self.head),
            tail.eq(Mux(on, beyond >= -1, Mux(back, beyond > 0, beyond >= 0))),
        ]
        source_at = Signal(half_bits(self.config))
        m.d.comb += source_at.eq(
            Mux(tail, beyond, position) + (on | back.replicate(len(source_at)))
        )

        source = Signal.like(self.source, reset_less=True)
        m.d.comb += self.source.eq(source)
        with m.If(self.advance):
            m.d.sync += [
                source.patched.eq(
                    (pending.perturb & here) | (pending.insert & (position == pending.at + 1))
                ),
                source.patch.eq(pending.patch),
                source.tail.eq(tail),
                source.at.eq(source_at),
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
            with m.If(self.source.patched):
                m.d.sync += waypoint.eq(chosen(self.source.patch, self.patches))
            with m.Elif(self.source.tail):
                m.d.sync += waypoint.eq(read["tail"])
            with m.Else():
                m.d.sync += waypoint.eq(read["head"])

        return m
