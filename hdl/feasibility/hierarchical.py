"""The hierarchical build: the coarse map first, the detailed one only where that is in the way."""

from amaranth import *
from amaranth.hdl import ResetInserter
from amaranth.lib import fifo, wiring
from amaranth.lib.wiring import connect, flipped

from hdl.config import Config
from hdl.feasibility.coarse import CoarseMap
from hdl.feasibility.delay import delayed
from hdl.feasibility.first_hit import FirstHit
from hdl.feasibility.hierarchical_cells import CellWalker, task_layout
from hdl.feasibility.hierarchical_columns import ColumnWalker
from hdl.feasibility.hierarchical_reads import PathReads
from hdl.feasibility.hierarchical_setup import HierarchicalSetup, group_cells
from hdl.feasibility.sizes import COLUMN_TASKS
from hdl.feasibility.terrain_memory import TerrainMemory
from hdl.feasibility.walker import walker_signature


__all__ = ["HierarchicalWalker"]


class HierarchicalWalker(wiring.Component):
    """Walks segments through the coarse map, and through the detailed one where that is hit.

    A column of cells, as wide as a coarse block, takes a clock in the coarse map: its one or two
    blocks are read at the two ports, and compared with the lowest altitude in the column. What is
    above both collides nowhere. All others wait in a queue of ``COLUMN_TASKS``, and are walked in
    order in the detailed map, :func:`hdl.feasibility.hierarchical_setup.group_cells` cells a clock.
    So the verdict is that of the detailed map alone, for every path. The last column of a segment
    always passes the queue, for a clock.

    A column comes 11 clocks after the second point of its segment, or when its turn is; its first
    cells, if they must be walked, are read ``memory_latency + 3`` clocks later, with several lanes
    ``memory_latency + 5``, and their step comes ``memory_latency + 3`` after that.

    In the clock of ``drop`` the cells of that clock are still read, and with several lanes those
    that were begun in the two clocks before it; all are counted.

    Points and writes wait while the coarse map is rebuilt: see
    :class:`hdl.feasibility.coarse.CoarseMap`.

    Source: *allaire two-tier*, section 5.3, which leaves it open what else two tiers are good for.

    Parameters
    ----------
    config : Config

    Members
    -------
    Those of :func:`hdl.feasibility.walker.walker_signature`.
    """

    def __init__(self, config: Config):
        self.config = config
        super().__init__(walker_signature(config))

    def elaborate(self, platform):
        m = Module()
        config, step = self.config, self.step

        m.submodules.setup = setup = HierarchicalSetup(config)
        m.submodules.columns = columns = ColumnWalker(config)
        m.submodules.cells = cells = CellWalker(config)
        m.submodules.terrain = terrain = TerrainMemory(config)
        m.submodules.coarse = coarse = CoarseMap(
            config, ports=2, scan_latency=config.lookup_latency
        )
        m.submodules.first_hit = first_hit = FirstHit(config)
        m.submodules.probes = probes = PathReads(config, most=2)
        m.submodules.reads = reads = PathReads(config, most=group_cells(config))

        drop_all, drop_tasks = Signal(), Signal()
        m.d.comb += [
            drop_all.eq(self.drop & ~probes.closed),
            drop_tasks.eq(self.drop & probes.closed & ~reads.closed),
        ]

        connect(m, setup.spans, columns.spans)
        m.d.comb += [
            setup.points.p.eq(self.points.p),
            setup.points.valid.eq(self.points.valid & ~coarse.busy),
            self.points.ready.eq(setup.points.ready & ~coarse.busy),
            columns.room.eq(self.room),
            columns.segment_room.eq(self.segment_room),
            columns.drop.eq(drop_all),
            self.begins.eq(columns.begins),
            self.segment_begins.eq(columns.segment_begins),
        ]

        # The coarse map.
        column, probe = columns.column, columns.probe
        for number, block in enumerate((probe.first, probe.last)):
            m.d.comb += [
                coarse.x[number].eq(Mux(column.steep, block, probe.row)),
                coarse.y[number].eq(Mux(column.steep, probe.row, block)),
            ]
        probed = columns.valid
        for clock in range(config.memory_latency + 1):
            earlier = Signal(name=f"probed_{clock}")
            m.d.sync += earlier.eq(probed & ~drop_all)
            probed = earlier
        tested = delayed(m, column, config.memory_latency + 1, "column")
        lowest = delayed(m, probe.lowest, config.memory_latency, "lowest")
        in_the_way = Signal(reset_less=True)
        m.d.sync += in_the_way.eq(Cat(highest >= lowest for highest in coarse.altitudes).any())

        # Tasks.
        push = Signal()
        pop = Signal()
        fresh = Signal(init=1)
        skipped = Signal(config.segment_cells_bits)
        task = Signal(task_layout(config))
        m.d.comb += [
            push.eq(probed & (in_the_way | tested.ends_segment)),
            task.column.eq(tested),
            task.walk.eq(in_the_way),
            task.skipped.eq(skipped),
            task.first.eq(fresh),
        ]
        with m.If(drop_all):
            m.d.sync += [fresh.eq(1), skipped.eq(0)]
        with m.Elif(push):
            m.d.sync += [fresh.eq(tested.ends_path), skipped.eq(0)]
        with m.Elif(probed):
            m.d.sync += skipped.eq(skipped + tested.more + 1)

        queue = fifo.SyncFIFO(width=task.shape().size, depth=COLUMN_TASKS)
        m.submodules.tasks = ResetInserter(drop_all)(queue)
        m.d.comb += [
            queue.w_data.eq(task),
            queue.w_en.eq(push),
            cells.tasks.p.eq(queue.r_data),
            cells.tasks.valid.eq(queue.r_rdy),
            pop.eq(cells.tasks.valid & cells.tasks.ready),
            queue.r_en.eq(cells.tasks.ready),
            cells.drop.eq(drop_all | drop_tasks),
            cells.follow.eq(drop_tasks),
        ]
        places = Signal(range(COLUMN_TASKS + 1), init=COLUMN_TASKS)
        m.d.comb += columns.allow.eq(places.any())
        m.d.sync += places.eq(
            Mux(drop_all, COLUMN_TASKS, places - columns.valid + (probed & ~push) + pop)
        )

        # The detailed map.
        write = self.writes.p
        connect(m, flipped(self.writes), coarse.writes)
        m.d.comb += [
            terrain.write_enable.eq(coarse.written),
            terrain.write_x.eq(write.x),
            terrain.write_y.eq(write.y),
            terrain.write_altitude.eq(write.altitude),
            terrain.lookup_valid.eq(coarse.scanning | self.lookup_valid),
            terrain.lookup_x.eq(Mux(coarse.scanning, coarse.scan_x, self.lookup_x)),
            terrain.lookup_y.eq(Mux(coarse.scanning, coarse.scan_y, self.lookup_y)),
            self.lookup_altitude.eq(terrain.lookup_altitude),
            coarse.scanned.eq(terrain.lookup_altitude),
            terrain.steep.eq(cells.group.steep),
            terrain.walking.eq(cells.valid & cells.passage.read),
            *(into.eq(lane) for into, lane in zip(terrain.lanes, cells.lanes, strict=True)),
        ]

        latency = config.memory_latency + 2
        valid = cells.valid
        for clock in range(latency + 1):
            earlier = Signal(name=f"passed_{clock}")
            m.d.sync += earlier.eq(valid)
            valid = earlier
        passage = delayed(m, cells.passage, latency + 1, "passage")
        m.d.comb += [
            first_hit.group.eq(delayed(m, cells.group, latency, "group")),
            first_hit.hits.eq(terrain.hits),
            first_hit.blocked.eq(terrain.blocked),
        ]

        m.d.comb += [
            probes.added.eq(Mux(columns.valid, 1 + (probe.first != probe.last), 0)),
            probes.ends.eq(columns.valid & column.ends_path),
            probes.drop.eq(drop_all),
            probes.over.eq(drop_tasks | (valid & passage.ends_path)),
            reads.added.eq(Mux(cells.beginning & cells.begun.read, cells.begun.cells, 0)),
            reads.ends.eq(cells.beginning & cells.begun.ends_path),
            reads.drop.eq(drop_all | drop_tasks),
            reads.over.eq(valid & passage.ends_path),
            step.valid.eq(valid),
            step.first.eq(passage.first),
            step.ends_segment.eq(passage.ends_segment),
            step.ends_path.eq(passage.ends_path),
            step.segment.eq(passage.segment),
            step.cells.eq(passage.skipped + passage.cells),
            step.hit.eq(first_hit.hit),
            step.until.eq(passage.skipped + first_hit.until),
            step.x.eq(first_hit.x),
            step.y.eq(first_hit.y),
            step.terrain.eq(first_hit.terrain),
            step.nofly.eq(first_hit.nofly),
            step.reads.eq(probes.reads + reads.reads),
        ]

        return m
