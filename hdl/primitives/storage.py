"""Storage: block RAM, memory of a map, long delay line, ring buffer with commits."""

from amaranth import *
from amaranth.lib import memory, stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import ceil_log2, exact_log2

from pathgene.hdl.primitives.cells import cells_of
from pathgene.hdl.primitives.logic import multiplex
from pathgene.hdl.primitives.unit import Choice, Count, Given, PowerOfTwo, Unit, Width


__all__ = ["BlockMemory", "CommitRing", "MapMemory", "MemoryDelay", "memory_members"]


def memory_members(*, rows, width, ports):
    """Return the members of a memory.

    Members
    -------
    a : In(Signature({address, write_enable, write_data, data}))
        ``address``: row to read or, with ``write_enable``, to write. ``data``: content of the row
        that was addressed ``latency`` cycles ago.
    b : In(Signature({address, data}))
        The second port, if ``ports`` is 2.
    """
    read = {"address": Out(ceil_log2(rows)), "data": In(width)}
    write = {"write_enable": Out(1), "write_data": Out(width)}
    members = {"a": In(wiring.Signature({**read, **write}))}
    if ports == 2:
        members["b"] = In(wiring.Signature(read))
    return members


class BlockMemory(Unit):
    """Memory with one or two read ports, written through the first.

    Rows are read in every cycle. Data read while a row is written are undefined, in all rows; rows
    never written are undefined. With a latency of 2, data come from registers: within the block
    RAMs if the platform's cells have them (:meth:`pathgene.hdl.primitives.cells.Cells.memory`),
    otherwise in the fabric.

    Members
    -------
    a, b
        See :func:`memory_members`.
    """

    rows: PowerOfTwo(2)
    width: Width(1, text="Bits of a row.")
    latency: Choice(1, 2, text="Cycles from an address to its data.")
    ports: Choice(1, 2)
    number: Given(
        "int or None",
        "Number of this memory among neighbours of the same size, from which a family's "
        "cells may choose its place on the device; None where the place does not matter.",
    ) = None

    def interface(self):
        return memory_members(rows=self.rows, width=self.width, ports=self.ports)

    def elaborate(self, platform):
        m = Module()

        cell = None
        if self.latency == 2:
            cell = cells_of(platform).memory(
                rows=self.rows, width=self.width, ports=self.ports, number=self.number
            )
        names = ("a", "b")[: self.ports]
        if cell is not None:
            m.submodules.hard = cell
            for name in names:
                connect(m, flipped(getattr(self, name)), getattr(cell, name))
            return m

        m.submodules.rows = rows = memory.Memory(
            shape=self.width, depth=self.rows, init=[], attrs={"no_rw_check": 1}
        )
        write = rows.write_port()
        m.d.comb += [
            write.addr.eq(self.a.address),
            write.data.eq(self.a.write_data),
            write.en.eq(self.a.write_enable),
        ]
        for name in names:
            port, read = getattr(self, name), rows.read_port()
            m.d.comb += read.addr.eq(port.address)
            data = read.data
            if self.latency == 2:
                data = Signal(self.width, name=f"out_{name}", reset_less=True)
                m.d.sync += data.eq(read.data)
            m.d.comb += port.data.eq(data)

        return m


class MemoryDelay(Unit):
    """Delays a word by a number of steps.

    It is a ring of rows, read and written at the end of a step, which takes a memory bit where
    registers would take a flip-flop.

    Members
    -------
    step : In(1)
        A step ends in this cycle.
    word : In(shape)
        Taken in the last cycle of a step.
    delayed : Out(shape)
        The word from ``steps`` steps ago, a register.
    """

    shape: Given("ShapeLike", "Shape of a word.")
    steps: Count(2)

    def interface(self):
        return {"step": In(1), "word": In(self.shape), "delayed": Out(self.shape)}

    def elaborate(self, platform):
        m = Module()

        # Once this row is written, the next row holds the word of `steps` steps ago: no row is read
        # and written in the same cycle.
        m.submodules.rows = ring = memory.Memory(
            shape=self.shape,
            depth=self.steps,
            init=[],
            attrs={"ram_style": cells_of(platform).ram_style, "no_rw_check": 1},
        )
        write, read = ring.write_port(), ring.read_port()
        at, following = Signal(range(self.steps)), Signal(range(self.steps))
        m.d.comb += [
            following.eq(Mux(at == self.steps - 1, 0, at + 1)),
            read.addr.eq(following),
            read.en.eq(self.step),
            write.addr.eq(at),
            write.data.eq(self.word),
            write.en.eq(self.step),
            self.delayed.eq(read.data),
        ]
        with m.If(self.step):
            m.d.sync += at.eq(following)

        return m


class CommitRing(Unit):
    """One block RAM between a writer that may discard rows and a stream.

    Row pointers count modulo ``2 * depth``, so that full and empty differ; a row number is a
    pointer without its highest bit. The rows from ``fetched`` up to but not including ``committed``
    are read in order; the writer may write all other rows in any order and any number of times. It
    must not write a row ``depth`` or more past ``fetched``.

    A row is offered 2 cycles after ``committed`` has moved past it, then one per cycle.
    Rows are read ahead: ``fetched`` leads the transferred words by up to two.

    On a target the memory is one block RAM with an output register. Its two ports never access the
    same row in the same cycle, as ``no_rw_check`` tells synthesis.

    Members
    -------
    write_enable : In(1)
    write_row : In(log2(depth))
    write_data : In(shape)
        Row written in each cycle with ``write_enable``.
    committed : In(log2(depth) + 1)
        Pointer past the last row that may be read; it only moves forward.
    fetched : Out(log2(depth) + 1)
        Pointer to the next row to be read.
    words : Out(stream.Signature(shape))
        Rows read.
    """

    shape: Given("ShapeLike", "Shape of a row.")
    depth: PowerOfTwo(2, text="Number of rows.")

    def interface(self):
        bits = exact_log2(self.depth)
        return {
            "write_enable": In(1),
            "write_row": In(bits),
            "write_data": In(self.shape),
            "committed": In(bits + 1),
            "fetched": Out(bits + 1),
            "words": Out(stream.Signature(self.shape)),
        }

    def elaborate(self, platform):
        m = Module()

        m.submodules.rows = rows = memory.Memory(
            shape=self.shape, depth=self.depth, init=[], attrs={"no_rw_check": 1}
        )
        write = rows.write_port()
        read = rows.read_port()

        loaded = Signal()  # The read port has a row that has not moved on.
        move_on = Signal()

        m.d.comb += [
            write.en.eq(self.write_enable),
            write.addr.eq(self.write_row),
            write.data.eq(self.write_data),
            move_on.eq(~self.words.valid | self.words.ready),
            read.en.eq((self.fetched != self.committed) & (~loaded | move_on)),
            read.addr.eq(self.fetched[:-1]),
        ]

        with m.If(read.en):
            m.d.sync += [
                self.fetched.eq(self.fetched + 1),
                loaded.eq(1),
            ]
        with m.Elif(move_on):
            m.d.sync += loaded.eq(0)
        with m.If(move_on):
            m.d.sync += [
                self.words.valid.eq(loaded),
                self.words.payload.eq(read.data),
            ]

        return m


class MapMemory(Unit):
    """Memory with one or two read ports, written through the first.

    It reads and writes as :class:`BlockMemory` does. On a target it is one memory of dual-port
    block RAMs without duplication: the writer shares a port with the first reader. With a latency
    of 2, registers directly follow the block RAMs of up to 16384 rows each; memories with more rows
    only add a multiplexer of these registers.

    Members
    -------
    a, b
        See :func:`pathgene.hdl.primitives.storage.memory_members`.
    """

    rows: PowerOfTwo(2)
    width: Width(1, text="Bits of a row.")
    latency: Choice(1, 2, text="Cycles from an address to its data.")
    ports: Choice(1, 2)
    number: Given(
        "int or None",
        "Number of the bank in its map, from which a family's cells may choose its place on "
        "the device.",
    ) = None

    #: Rows of the deepest block RAM: 16384 of one bit.
    BLOCK_ROWS = 1 << 14

    def interface(self):
        return memory_members(rows=self.rows, width=self.width, ports=self.ports)

    def elaborate(self, platform):
        m = Module()

        depth = min(self.rows, self.BLOCK_ROWS)
        blocks = self.rows // depth
        bits = ceil_log2(depth)
        ports = [self.a, self.b] if self.ports == 2 else [self.a]
        data = [[] for _ in ports]
        for number in range(blocks):
            block = BlockMemory(
                rows=depth,
                width=self.width,
                latency=self.latency,
                ports=self.ports,
                number=None if self.number is None else self.number * blocks + number,
            )
            m.submodules[f"block_{number}"] = block
            enable = self.a.write_enable
            if blocks > 1:
                enable = enable & (self.a.address[bits:] == number)
            m.d.comb += [
                block.a.write_data.eq(self.a.write_data),
                block.a.write_enable.eq(enable),
            ]
            members = [block.a, block.b] if self.ports == 2 else [block.a]
            for source, member, outs in zip(ports, members, data, strict=True):
                m.d.comb += member.address.eq(source.address)
                outs.append(member.data)

        for port, (source, outs) in enumerate(zip(ports, data, strict=True)):
            block = source.address[bits:]
            for cycle in range(self.latency if blocks > 1 else 0):
                earlier = Signal(len(block), name=f"at_{port}_{cycle}", reset_less=True)
                m.d.sync += earlier.eq(block)
                block = earlier
            m.d.comb += source.data.eq(multiplex(block, outs))

        return m
