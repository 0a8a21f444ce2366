"""Walker of the two-tier build: one cell per cycle, in the detailed map, then the coarse map."""

from amaranth import *
from amaranth.lib.wiring import connect, flipped

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.layouts import walker_signature
from pathgene.hdl.feasibility.two_tier.cell_walker import AltitudeComparator, CellWalker
from pathgene.hdl.feasibility.two_tier.coarse_map import CoarseMap
from pathgene.hdl.feasibility.two_tier.segment_setup import TwoTierSegmentSetup
from pathgene.hdl.primitives.storage import MapMemory
from pathgene.hdl.primitives.unit import InstanceOf, Unit


__all__ = ["TwoTierWalker"]


class TwoTierWalker(Unit):
    """Walks the first two segments of a path in the detailed map, the rest in the coarse map.

    With a source that always has the next point, the first cell of a path is visited 4 cycles after
    its first point is taken, and then one cell each cycle; segments and paths follow each other
    without a gap. The step of a cell follows its visit by ``memory_latency + 3`` cycles. A path of
    c cells is therefore decided ``c + memory_latency + 6`` cycles after its first point is taken,
    counting that cycle, and its verdict is offered in the next cycle.

    In the cycle of ``drop``, one more address is given and counted. The remaining points of the
    path are taken, one per cycle.

    Points and writes wait while the coarse map is rebuilt: see
    :class:`pathgene.hdl.feasibility.two_tier.coarse_map.CoarseMap`.

    Source: *allaire two-tier*, section 3. Differences: the set-up of segments and paths overlaps
    the walk, and altitudes are compared exactly.

    Members
    -------
    Those of :func:`pathgene.hdl.feasibility.layouts.walker_signature`.
    """

    config: InstanceOf(Config)

    def interface(self):
        return walker_signature(self.config)

    def elaborate(self, platform):
        m = Module()
        config = self.config
        xy, z = config.coordinate_bits, config.altitude_bits

        m.submodules.setup = setup = TwoTierSegmentSetup(
            xy, config.coarse_bits, z, config.segment_bits, config.DETAILED_SEGMENTS
        )
        m.submodules.line = line = CellWalker(xy, z, config.segment_bits)
        m.submodules.compare = compare = AltitudeComparator(
            xy, z, config.segment_bits, config.memory_latency
        )
        m.submodules.detailed = detailed = MapMemory(
            rows=config.map_size**2,
            width=z,
            latency=config.memory_latency,
            ports=1,
            number=0,
        )
        m.submodules.coarse = coarse = CoarseMap(
            xy,
            config.coarse_bits,
            z,
            memory_latency=config.memory_latency,
            scan_latency=config.lookup_latency,
        )

        visit = line.visit
        connect(m, setup.segments, line.segments)
        m.d.comb += [
            setup.points.p.eq(self.points.p),
            setup.points.valid.eq(self.points.valid & ~coarse.busy),
            self.points.ready.eq(setup.points.ready & ~coarse.busy),
            line.room.eq(self.room),
            line.segment_room.eq(self.segment_room),
            self.begins.eq(line.begins),
            self.segment_begins.eq(line.segment_begins),
            compare.visiting.eq(line.visiting),
            compare.visit.eq(visit),
            compare.level.eq(line.level),
        ]

        # All other accesses go through a register, so that the walk has the shortest path to the
        # memory.
        write = self.writes.p
        connect(m, flipped(self.writes), coarse.writes)
        address = Signal(2 * xy, reset_less=True)
        with m.If(coarse.scanning):
            m.d.sync += address.eq(Cat(coarse.scan_x, coarse.scan_y))
        with m.Elif(coarse.written):
            m.d.sync += address.eq(Cat(write.x, write.y))
        with m.Else():
            m.d.sync += address.eq(Cat(self.lookup_x, self.lookup_y))
        port = detailed.a
        m.d.sync += [port.write_enable.eq(coarse.written), port.write_data.eq(write.altitude)]
        m.d.comb += [
            port.address.eq(Mux(line.visiting, Cat(visit.x, visit.y), address)),
            coarse.x.eq(visit.x),
            coarse.y.eq(visit.y),
        ]

        # The map that is read: for look-ups and scans, which never coincide with a walk, the
        # detailed map.
        from_coarse = line.visiting & visit.coarse
        for cycle in range(config.memory_latency):
            earlier = Signal(name=f"from_coarse_{cycle}", reset_less=True)
            m.d.sync += earlier.eq(from_coarse)
            from_coarse = earlier
        ground = Signal(z, reset_less=True)
        m.d.sync += ground.eq(Mux(from_coarse, coarse.altitude, port.data))
        m.d.comb += [
            compare.ground.eq(ground),
            self.lookup_altitude.eq(ground),
            coarse.scanned.eq(ground),
        ]

        tested, step = compare.tested, self.step
        passed = Signal(config.path_cells_bits)
        drop = Signal()
        m.d.comb += [
            drop.eq(self.drop & tested.open),
            line.drop.eq(drop),
            compare.drop.eq(drop),
            step.valid.eq(compare.valid),
            step.first.eq(tested.visit.first),
            step.ends_segment.eq(tested.visit.ends_segment),
            step.ends_path.eq(tested.visit.ends_path),
            step.segment.eq(tested.visit.segment),
            step.coarse.eq(tested.visit.coarse),
            step.x.eq(tested.visit.x),
            step.y.eq(tested.visit.y),
            step.cells.eq(1),
            step.hit.eq(tested.hit),
            step.until.eq(1),
            step.terrain.eq(tested.hit & ~tested.blocked),
            step.nofly.eq(tested.hit & tested.blocked),
            step.reads.eq(Mux(tested.visit.first, 0, passed) + 1 + tested.reads),
        ]
        with m.If(compare.valid):
            m.d.sync += passed.eq(Mux(tested.visit.first, 0, passed) + 1)

        return m
