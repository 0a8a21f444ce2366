"""Walker of the parallel build: every segment in the detailed map, several cells per cycle."""

from amaranth import *
from amaranth.lib import memory
from amaranth.lib.wiring import connect, flipped

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.layouts import walker_signature
from pathgene.hdl.feasibility.parallel.lanes import HitLocator, Lanes, Slopes
from pathgene.hdl.feasibility.parallel.segment_setup import TAG_BITS, SegmentSetup, token_layout
from pathgene.hdl.feasibility.parallel.terrain_memory import TerrainMemory
from pathgene.hdl.primitives.logic import delay_line
from pathgene.hdl.primitives.unit import InstanceOf, Unit


__all__ = ["ParallelWalker"]


class ParallelWalker(Unit):
    """Walks all segments in the detailed map, ``lanes`` cells per cycle.

    A segment of n cells takes n / ``lanes`` cycles, rounded up. Segments and paths follow each
    other without a gap as long as the next point is available and no path is dropped. A single path
    of G such cycles, with points in successive cycles, is decided ``G + memory_latency + 9`` cycles
    after its first point is taken, counting that cycle. Its verdict is offered in the next cycle:
    after ``G + 12`` cycles with a latency of 2. A segment's first group follows its second point by
    5 cycles: two for set-up, two for slopes, one to the banks. A group's step follows the group by
    ``memory_latency + 3`` cycles: comparison, bank, first hit.

    In the cycle of ``drop``, the group of the path is still read. The remaining points of the path
    are taken, one per cycle.

    Source: *allaire two-tier*, section 5.3.

    Members
    -------
    Those of :func:`pathgene.hdl.feasibility.layouts.walker_signature`.
    """

    config: InstanceOf(Config)

    def interface(self):
        return walker_signature(self.config)

    def elaborate(self, platform):
        m = Module()
        config, step = self.config, self.step
        xy, z = config.coordinate_bits, config.altitude_bits
        drop_tag = Signal(TAG_BITS)

        m.submodules.setup = setup = SegmentSetup(config.lanes, xy, z, config.segment_bits)
        m.submodules.slopes = slopes = Slopes(config.lanes, xy, z)
        m.submodules.lanes = lanes = Lanes(config.lanes, xy, z, config.segment_bits)
        m.submodules.terrain = terrain = TerrainMemory(config.lanes, xy, z, config.memory_latency)
        m.submodules.hit_locator = hit_locator = HitLocator(config.lanes, xy)
        connect(m, flipped(self.points), setup.points)
        m.d.comb += [
            setup.room.eq(self.room),
            setup.segment_room.eq(self.segment_room),
            setup.drop.eq(self.drop),
            setup.drop_tag.eq(drop_tag),
            self.begins.eq(setup.begins),
            self.segment_begins.eq(setup.segment_begins),
            slopes.segment.eq(setup.segment),
        ]

        # Cells of a dropped path do not reach the memory.
        def unless_dropped(token):
            return token.valid & ~(self.drop & (token.tag == drop_tag))

        launched, token = (
            Signal(token_layout(config.segment_bits), name=name) for name in ("launched", "token")
        )
        m.d.sync += [
            launched.eq(setup.token),
            token.eq(lanes.token),
            token.valid.eq(unless_dropped(lanes.token)),
        ]
        m.d.comb += [
            lanes.launched.eq(launched),
            lanes.launched.valid.eq(unless_dropped(launched)),
            lanes.segment.eq(delay_line(m, setup.segment, 1, "segment")),
            lanes.step.eq(slopes.step),
            *(into.eq(start) for into, start in zip(lanes.origins, slopes.origins, strict=True)),
        ]

        # Writes cross the chip as well.
        writing = Signal()
        m.d.sync += writing.eq(self.writes.valid)
        written = {
            name: delay_line(m, self.writes.p[name], 1, f"write_{name}")
            for name in ("x", "y", "altitude")
        }

        m.d.comb += [
            terrain.steep.eq(lanes.group.steep),
            terrain.walking.eq(lanes.token.valid),
            *(into.eq(lane) for into, lane in zip(terrain.lanes, lanes.lanes, strict=True)),
            self.writes.ready.eq(1),
            terrain.write_enable.eq(writing),
            *(getattr(terrain, f"write_{name}").eq(value) for name, value in written.items()),
            terrain.lookup_valid.eq(self.lookup_valid),
            terrain.lookup_x.eq(self.lookup_x),
            terrain.lookup_y.eq(self.lookup_y),
            self.lookup_altitude.eq(terrain.lookup_altitude),
        ]

        # Addresses given for each path in flight, including the group of this cycle.
        m.submodules.reads = reads = memory.Memory(
            shape=config.path_cells_bits + 1, depth=1 << TAG_BITS, init=[]
        )
        write, read = reads.write_port(), reads.read_port(domain="comb")
        given, before = (Signal(config.path_cells_bits + 1, name=n) for n in ("given", "before"))
        cells = delay_line(m, lanes.group.cells, 1, "cells_given")
        m.d.comb += [
            given.eq(Mux(token.first, 0, before) + cells),
            write.addr.eq(token.tag),
            write.data.eq(given),
            write.en.eq(token.valid),
        ]
        with m.If(token.valid):
            m.d.sync += before.eq(given)

        # Group and token wait for the memory's answer.
        latency = config.memory_latency + 2
        group = delay_line(m, lanes.group, latency + 1, "group")
        cells = delay_line(m, group.cells, 1, "cells")
        stepped = token
        for cycle in range(latency + 1):
            following = Signal.like(token, name=f"token_{cycle}")
            m.d.sync += following.eq(stepped)
            stepped = following

        is_reading = Signal()
        m.d.comb += [
            drop_tag.eq(stepped.tag),
            hit_locator.group.eq(group),
            hit_locator.hits.eq(terrain.hits),
            hit_locator.blocked.eq(terrain.blocked),
            read.addr.eq(stepped.tag),
            is_reading.eq(token.valid & (token.tag == stepped.tag)),
        ]
        m.d.comb += [
            step.valid.eq(stepped.valid),
            step.first.eq(stepped.first),
            step.ends_segment.eq(stepped.ends_segment),
            step.ends_path.eq(stepped.ends_path),
            step.segment.eq(stepped.segment),
            step.cells.eq(cells),
            step.hit.eq(hit_locator.hit),
            step.until.eq(hit_locator.until),
            step.x.eq(hit_locator.x),
            step.y.eq(hit_locator.y),
            step.terrain.eq(hit_locator.terrain),
            step.nofly.eq(hit_locator.nofly),
            step.reads.eq(Mux(is_reading, given, read.data)),
        ]

        return m
