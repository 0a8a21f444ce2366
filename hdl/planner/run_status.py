"""Status of the latest run: its progress, and the cycles of its units."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.layouts import KEY_BITS
from pathgene.hdl.primitives.unit import Unit
from pathgene.hdl.protocol.codes import UNITS
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass


__all__ = ["RunStatus", "run_status_layout"]

_COUNTER_BITS = 32


def run_status_layout() -> data.StructLayout:
    """Return the layout of the status of a run: its fields in the reply to STATUS."""
    counters = ("generation", "cycles", "key", *UNITS)
    return data.StructLayout({"running": 1, **dict.fromkeys(counters, _COUNTER_BITS)})


class RunStatus(Unit):
    """Counts the cycles of the units in a run, and stores the key of its best path.

    Members
    -------
    launch : In(1)
        Pulse: a run begins.
    running : In(1)
    generations, cycles, score, walk : In(32)
        Counts of the latest run.
    planning, sorting, spreading : In(1)
        Children are being planned, populations sorted, blocks scanned or routes found.
    bred : In(1)
        Pulse: a generation begins. ``best`` is the key of its population 3 cycles later.
    best : In(KEY_BITS)
        Key of the best path of the population last bred from.
    first : In(KEY_BITS)
        Key of the best path, if ``is_first``.
    is_first : In(1)
    void : In(1)
        Pulse: there are no more paths.
    status : Out(run_status_layout)
        Counters stay until the next run. ``running`` and the counts of planning, sorting and
        spreading lag by one cycle; the counts are complete once it is low. ``key`` is void until a
        generation has begun or the run is over, and again from two cycles after ``void`` on.
    """

    def interface(self):
        inputs = {name: In(_COUNTER_BITS) for name in ("generations", "cycles", "score", "walk")}
        flags = ("launch", "running", "planning", "sorting", "spreading", "bred", "is_first")
        return {
            **inputs,
            **{name: In(1) for name in (*flags, "void")},
            "best": In(KEY_BITS),
            "first": In(KEY_BITS),
            "status": Out(run_status_layout()),
        }

    def elaborate(self, platform):
        m = Module()

        status = self.status
        m.d.comb += [
            status.generation.eq(self.generations),
            status.cycles.eq(self.cycles),
            status.score.eq(self.score),
            status.walk.eq(self.walk),
        ]
        # Delay all inputs by one cycle, because they arrive late.
        launched = Signal()
        m.d.sync += [launched.eq(self.launch), status.running.eq(self.running)]
        counted = {"breed": self.planning, "sort": self.sorting, "wavefront": self.spreading}
        for name, is_busy in counted.items():
            counts = Signal(name=f"counts_{name}")
            counter = Signal(_COUNTER_BITS, name=name)
            m.d.sync += [
                counts.eq(is_busy & self.running),
                counter.eq(Mux(launched, 0, counter + counts)),
            ]
            m.d.comb += status[name].eq(counter)

        key = Signal(KEY_BITS, init=PathClass.VOID << VALUE_BITS)
        since = Signal(3)
        m.d.comb += status.key.eq(key)
        m.d.sync += since.eq(Cat(self.bred, since))
        with m.If(since[-1]):
            m.d.sync += key.eq(self.best)
        with m.If(self.is_first):
            m.d.sync += key.eq(self.first)
        # Delay both by one cycle, because they arrive late.
        voids = Signal()
        m.d.sync += voids.eq(self.launch | self.void)
        with m.If(voids):
            m.d.sync += key.eq(PathClass.VOID << VALUE_BITS)

        return m
