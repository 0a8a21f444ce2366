"""Queue of the margins that are to be written."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import ceil_log2, exact_log2

from hdl.planner.evaluator.layouts import PLACES
from hdl.planner.population_memory import margin_layout
from hdl.planner.walker.path_reducer import margin_layout as walked_margin_layout
from hdl.primitives.arguments import check_integer
from hdl.primitives.commit_ring import CommitRing


__all__ = ["MarginQueue"]

#: Cycles by which those without ``ready`` may exceed a half.
_AHEAD = 64
#: Cycles from the arrival of a margin to its offer.
_LATENCY = 3


class MarginQueue(wiring.Component):
    """Keeps margins until they are taken; a margin is offered 3 cycles after it comes.

    No margin is lost while the receiver is ready in half of all cycles: of any T in a row, in at
    least T / 2 - 64. The breeder, whose writes come first, keeps to that. Its waypoints are points
    that the scorer takes, one every two cycles, and a few more that are made ahead.

    In T cycles come the margins of the 16 paths inside, 16 ``max_waypoints``, and those of paths
    that enter meanwhile, n for every 2 (n + 2) cycles: fewer than T / 2. So at most 16
    ``max_waypoints`` + 64 wait. It takes a long walk, then 16 paths whose segments the memo has
    nearly all, to come near. On a target the queue is a block RAM, of 512 rows with 16 waypoints.

    Parameters
    ----------
    slots : int
        Paths of the population, 2 or more.
    max_waypoints : int
        Waypoints of the longest path, 2 or more.
    altitude_bits : int
        Width of an altitude, 1 or more.

    Members
    -------
    slot : In(range(slots))
        With ``margin``: slot of its path.
    margin : In(walked_margin_layout)
    margins : Out(stream.Signature(margin_layout))
    idle : Out(1)
        No margin waits.

    Raises
    ------
    TypeError, ValueError
        If a parameter is not an integer, or out of its range.
    """

    def __init__(self, slots: int, max_waypoints: int, altitude_bits: int):
        check_integer("Slots", slots, 2)
        check_integer("Max waypoints", max_waypoints, 2)
        check_integer("Altitude width", altitude_bits, 1)
        self.slots = slots
        self.max_waypoints = max_waypoints
        self.altitude_bits = altitude_bits
        self.depth = 1 << ceil_log2(PLACES * max_waypoints + _AHEAD + _LATENCY)
        self.layout = margin_layout(slots, max_waypoints, altitude_bits)
        index_bits = (max_waypoints - 1).bit_length()
        super().__init__(
            {
                "slot": In(range(slots)),
                "margin": In(walked_margin_layout(altitude_bits, index_bits)),
                "margins": Out(stream.Signature(self.layout)),
                "idle": Out(1),
            }
        )

    def elaborate(self, platform):
        m = Module()

        m.submodules.ring = ring = CommitRing(self.layout, self.depth)
        written, waiting = Signal(exact_log2(self.depth) + 1), Signal(range(self.depth + 1))
        connect(m, ring.words, flipped(self.margins))
        m.d.comb += [
            ring.write_enable.eq(self.margin.valid),
            ring.write_row.eq(written),
            ring.write_data.place.slot.eq(self.slot),
            ring.write_data.place.index.eq(self.margin.index),
            ring.write_data.margin.eq(self.margin.margin),
            ring.committed.eq(written),
            self.idle.eq(waiting == 0),
        ]
        m.d.sync += [
            written.eq(written + self.margin.valid),
            waiting.eq(waiting + self.margin.valid - (self.margins.valid & self.margins.ready)),
        ]

        return m
