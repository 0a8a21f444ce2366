"""One memory of altitudes, for a map or for a part of one."""

from amaranth import *
from amaranth.lib import memory, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from hdl.ga_core.multiplexer import chosen


__all__ = ["TerrainBank"]


class TerrainBank(wiring.Component):
    """Memory that is read through one or two ports, and written through the first.

    Rows are read in every clock. What a port reads while a row is written is undefined, in all
    rows; rows never written hold anything.

    On a target it is one memory of dual-port block RAMs, none of them doubled: the writer is the
    same port as the first reader. With a latency of 2 the data come out of registers straight
    behind the block RAMs of up to 16384 rows; where there are more rows, a multiplexer of these
    registers is all that follows.

    Parameters
    ----------
    rows : int
        A power of two, 2 or more.
    width : int
        Bits of a row.
    latency : int
        Clocks from an address to its data, 1 or 2.
    ports : int
        Ports, 1 or 2.

    Members
    -------
    a : In(Signature({address, write_enable, write_data, data}))
        ``address``: row to be read, or with ``write_enable`` to be written. ``data``: what is in
        the row that was addressed ``latency`` clocks ago.
    b : In(Signature({address, data}))
        The second port, if there is one.

    Raises
    ------
    ValueError
        If a parameter is out of its range.
    """

    #: Rows of the deepest block RAM (ECP5: 16384 of one bit).
    BLOCK_ROWS = 1 << 14

    def __init__(self, *, rows, width, latency, ports):
        if rows < 2 or rows & (rows - 1):
            raise ValueError(f"Rows must be a power of two from 2 on, not {rows!r}")
        if latency not in (1, 2):
            raise ValueError(f"Latency must be 1 or 2, not {latency!r}")
        if ports not in (1, 2):
            raise ValueError(f"Ports must be 1 or 2, not {ports!r}")

        self.rows = rows
        self.width = width
        self.latency = latency
        self.ports = ports
        bits = ceil_log2(rows)
        read = {"address": Out(bits), "data": In(width)}
        write = {"write_enable": Out(1), "write_data": Out(width)}
        members = {"a": In(wiring.Signature({**read, **write}))}
        if ports == 2:
            members["b"] = In(wiring.Signature(read))
        super().__init__(members)

    def elaborate(self, platform):
        m = Module()

        depth = min(self.rows, self.BLOCK_ROWS)
        blocks = self.rows // depth
        bits = ceil_log2(depth)
        ports = [self.a, self.b] if self.ports == 2 else [self.a]
        data = [[] for _ in ports]
        for number in range(blocks):
            rows = memory.Memory(shape=self.width, depth=depth, init=[], attrs={"no_rw_check": 1})
            m.submodules[f"block_{number}"] = rows
            write = rows.write_port()
            m.d.comb += [
                write.addr.eq(self.a.address),
                write.data.eq(self.a.write_data),
                write.en.eq(self.a.write_enable),
            ]
            if blocks > 1:
                m.d.comb += write.en.eq(self.a.write_enable & (self.a.address[bits:] == number))
            for port, (source, into) in enumerate(zip(ports, data, strict=True)):
                read = rows.read_port()
                m.d.comb += read.addr.eq(source.address)
                out = read.data
                if self.latency == 2:
                    out = Signal(self.width, name=f"out_{number}_{port}", reset_less=True)
                    m.d.sync += out.eq(read.data)
                into.append(out)

        for port, (source, outs) in enumerate(zip(ports, data, strict=True)):
            block = source.address[bits:]
            for clock in range(self.latency if blocks > 1 else 0):
                earlier = Signal(len(block), name=f"at_{port}_{clock}", reset_less=True)
                m.d.sync += earlier.eq(block)
                block = earlier
            m.d.comb += source.data.eq(chosen(block, outs))

        return m
