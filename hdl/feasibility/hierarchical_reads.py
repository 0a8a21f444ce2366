"""Counts what the memories are given for each path, some paths ahead of its verdict."""

from amaranth import *
from amaranth.lib import fifo, wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config


__all__ = ["PathReads"]


class PathReads(wiring.Component):
    """Reads of the path that is to be decided next, whether or not they have come to their end.

    Parameters
    ----------
    config : Config
    most : int
        Reads in a clock, at most.

    Members
    -------
    added : In(range(most + 1))
        Reads of this clock.
    ends : In(1)
        With them all reads of a path have been made.
    closed : Out(1)
        So it is, since before this clock, for the path to be decided next.
    reads : Out(path_cells_bits + 1)
        Its reads so far, those of this clock included.
    over : In(1)
        That path is over; only while ``closed``. At most :attr:`PATHS` may be ``closed`` at a time.
    drop : In(1)
        It is over, and makes no more reads; only while not ``closed``.
    """

    #: Paths that can be closed at a time. Verdicts that can be kept, and those before them.
    PATHS = 16

    def __init__(self, config: Config, *, most: int):
        self.config = config
        super().__init__(
            {
                "added": In(range(most + 1)),
                "ends": In(1),
                "closed": Out(1),
                "reads": Out(config.path_cells_bits + 1),
                "over": In(1),
                "drop": In(1),
            }
        )

    def elaborate(self, platform):
        m = Module()

        m.submodules.totals = totals = fifo.SyncFIFO(width=len(self.reads), depth=self.PATHS)
        counted = Signal.like(self.reads)
        now = Signal.like(self.reads)
        m.d.comb += [
            now.eq(counted + self.added),
            totals.w_data.eq(now),
            totals.w_en.eq(self.ends & ~self.drop),
            totals.r_en.eq(self.over),
            self.closed.eq(totals.r_rdy),
            self.reads.eq(Mux(self.closed, totals.r_data, now)),
        ]
        m.d.sync += counted.eq(Mux(self.ends | self.drop, 0, now))

        return m
