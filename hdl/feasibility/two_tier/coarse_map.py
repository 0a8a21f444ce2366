"""Coarse map: the highest cell of every block of the detailed map, kept up to date."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.layouts import cell_layout
from pathgene.hdl.primitives.storage import MapMemory
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["CoarseMap"]


class CoarseMap(Unit):
    """Memory of the maxima of square blocks of cells.

    Cells written to the detailed map pass through this unit, which records the blocks that they
    span. After the last cell of a rectangle, it reads every cell of those blocks again, one per
    cycle, and writes their maxima, so that maxima can also decrease. ``busy`` is high for one cycle
    per cell of these blocks and ``scan_latency + 2`` more, from the cycle after the last cell on.

    Source: *allaire two-tier*, section 3.1.1.

    Members
    -------
    writes : In(stream.Signature(cell_layout))
        Cells of the detailed map; ``last`` ends a rectangle. Taken while not ``busy``.
    written : Out(1)
        The offered cell is taken: write it to the detailed map.
    busy : Out(1)
        Blocks are being read.
    scanning : Out(1)
        Read cell ``scan_x``, ``scan_y`` of the detailed map.
    scan_x, scan_y : Out(coordinate_bits)
    scanned : In(altitude_bits)
        Altitude of the cell requested ``scan_latency`` cycles ago, with every write before ``busy``
        applied.
    x, y : In(coarse_bits)
        Block to be read, not while ``busy``.
    altitude : Out(altitude_bits)
        Maximum of the block, ``memory_latency`` cycles later; undefined until the block has been
        scanned. See :class:`pathgene.hdl.primitives.storage.MapMemory`.
    """

    coordinate_bits: Width(2, text="In cells.")
    coarse_bits: Width(1, "coordinate_bits - 1", "Width of a coordinate in blocks.")
    altitude_bits: Width(1)
    memory_latency: Count(1, 2, "Cycles from a block to its maximum.")
    scan_latency: Count(
        1, text="Cycles from ``scanning`` to its ``scanned``.", name="Latency of a scan"
    )

    def interface(self):
        return {
            "writes": In(stream.Signature(cell_layout(self.coordinate_bits, self.altitude_bits))),
            "written": Out(1),
            "busy": Out(1),
            "scanning": Out(1),
            "scan_x": Out(self.coordinate_bits),
            "scan_y": Out(self.coordinate_bits),
            "scanned": In(self.altitude_bits),
            "x": In(self.coarse_bits),
            "y": In(self.coarse_bits),
            "altitude": Out(self.altitude_bits),
        }

    def elaborate(self, platform):
        m = Module()
        coarse_bits = self.coarse_bits
        bits = self.coordinate_bits - coarse_bits

        cell = self.writes.p
        m.d.comb += [
            self.writes.ready.eq(~self.busy),
            self.written.eq(self.writes.valid & self.writes.ready),
        ]

        # Blocks written to since the last rectangle ended.
        block_x, block_y = cell.x >> bits, cell.y >> bits
        fresh = Signal(init=1)
        west, east, south, north = (
            Signal(coarse_bits, name=name) for name in ("west", "east", "south", "north")
        )
        with m.If(self.written):
            m.d.sync += fresh.eq(cell.last)
            with m.If(fresh | (block_x < west)):
                m.d.sync += west.eq(block_x)
            with m.If(fresh | (block_x > east)):
                m.d.sync += east.eq(block_x)
            with m.If(fresh | (block_y < south)):
                m.d.sync += south.eq(block_y)
            with m.If(fresh | (block_y > north)):
                m.d.sync += north.eq(block_y)

        # One cycle to settle, then all cells of each block in turn.
        starting = Signal()
        m.d.sync += starting.eq(self.written & cell.last)
        at_x, at_y = Signal(coarse_bits), Signal(coarse_bits)
        inner_x, inner_y = Signal(bits), Signal(bits)
        block_ends = Signal()
        m.d.comb += [
            self.scan_x.eq(Cat(inner_x, at_x)),
            self.scan_y.eq(Cat(inner_y, at_y)),
            block_ends.eq(Cat(inner_x, inner_y).all()),
        ]
        with m.If(starting):
            m.d.sync += [
                self.scanning.eq(1),
                at_x.eq(west),
                at_y.eq(south),
                Cat(inner_x, inner_y).eq(0),
            ]
        with m.Elif(self.scanning):
            m.d.sync += Cat(inner_x, inner_y).eq(Cat(inner_x, inner_y) + 1)
            with m.If(block_ends):
                m.d.sync += at_x.eq(Mux(at_x == east, west, at_x + 1))
                with m.If(at_x == east):
                    m.d.sync += at_y.eq(at_y + 1)
                    with m.If(at_y == north):
                        m.d.sync += self.scanning.eq(0)

        # Data read, with their blocks.
        block = {"x": coarse_bits, "y": coarse_bits}
        asked = Signal(data.StructLayout({"valid": 1, "first": 1, "last": 1, **block}))
        m.d.comb += [
            asked.valid.eq(self.scanning),
            asked.first.eq(~Cat(inner_x, inner_y).any()),
            asked.last.eq(block_ends),
            asked.x.eq(at_x),
            asked.y.eq(at_y),
        ]
        in_flight = [starting, self.scanning]
        for cycle in range(self.scan_latency):
            following = Signal.like(asked, name=f"asked_{cycle}")
            m.d.sync += following.eq(asked)
            asked = following
            in_flight.append(asked.valid)

        highest = Signal(self.altitude_bits)
        writing = Signal()
        row = Signal(2 * coarse_bits)
        m.d.sync += [
            writing.eq(asked.valid & asked.last),
            row.eq(Cat(asked.x, asked.y)),
        ]
        with m.If(asked.valid & (asked.first | (self.scanned > highest))):
            m.d.sync += highest.eq(self.scanned)
        m.d.comb += self.busy.eq(Cat(in_flight).any() | writing)

        m.submodules.blocks = blocks = MapMemory(
            rows=1 << len(row),
            width=self.altitude_bits,
            latency=self.memory_latency,
            ports=1,
        )
        port = blocks.a
        m.d.comb += [
            port.write_enable.eq(writing),
            port.write_data.eq(highest),
            port.address.eq(Mux(writing, row, Cat(self.x, self.y))),
            self.altitude.eq(port.data),
        ]

        return m
