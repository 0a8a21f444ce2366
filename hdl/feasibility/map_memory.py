"""Memory of altitudes, for a map or part of one."""

from amaranth import *
from amaranth.utils import ceil_log2

from pathgene.hdl.primitives.logic import multiplex
from pathgene.hdl.primitives.storage import BlockMemory, memory_members
from pathgene.hdl.primitives.unit import Choice, Given, PowerOfTwo, Unit, Width


__all__ = ["MapMemory"]


class MapMemory(Unit):
    """Memory with one or two read ports, written through the first.

    Rows are read in every cycle. Data read while a row is written are undefined, in all rows; rows
    never written are undefined.

    On a target it is one memory of dual-port block RAMs without duplication: the writer shares a
    port with the first reader. With a latency of 2, registers directly follow the block RAMs of up
    to 16384 rows each; memories with more rows only add a multiplexer of these registers.

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
