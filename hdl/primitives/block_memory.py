"""Memory that one block RAM is deep enough for."""

from amaranth import *
from amaranth.lib import memory, wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import ceil_log2

from pathgene.hdl.primitives.cells import cells_of
from pathgene.hdl.primitives.unit import Choice, Given, PowerOfTwo, Unit, Width


__all__ = ["BlockMemory", "memory_members"]


def memory_members(*, rows, width, ports):
    """Return the members of a memory.

    Members
    -------
    a : In(Signature({address, write_enable, write_data, data}))
        ``address``: row to be read, or with ``write_enable`` to be written. ``data``: content of
        the row that was addressed ``latency`` cycles ago.
    b : In(Signature({address, data}))
        The second port, with ``ports`` of 2.
    """
    read = {"address": Out(ceil_log2(rows)), "data": In(width)}
    write = {"write_enable": Out(1), "write_data": Out(width)}
    members = {"a": In(wiring.Signature({**read, **write}))}
    if ports == 2:
        members["b"] = In(wiring.Signature(read))
    return members


class BlockMemory(Unit):
    """Memory that is read through one or two ports, and written through the first.

    Rows are read in every cycle. Data read while a row is written are undefined, in all rows; rows
    never written are undefined. With a latency of 2, data come out of registers: within the block
    RAMs where the platform's cells have them (:meth:`pathgene.hdl.primitives.cells.Cells.memory`),
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
