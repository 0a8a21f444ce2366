"""Comparison of a path's exact altitude with the ground, cell by cell."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.feasibility.two_tier.cell_walker import level_layout, visit_layout
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["AltitudeComparator", "tested_layout"]


def tested_layout(coordinate_bits: int, segment_bits: int, latency: int) -> data.StructLayout:
    """Return the layout of a cell that has been compared.

    ``hit``: the path is not above its ground. ``blocked``: no path may cross that ground.
    ``reads``: addresses of the same path given to a memory since, including this cycle's. ``open``:
    neither this cell nor any cell read since is the path's last. ``latency``: cycles from a visit
    to its test.
    """
    return data.StructLayout(
        {
            "visit": visit_layout(coordinate_bits, segment_bits),
            "hit": 1,
            "blocked": 1,
            "reads": range(latency + 1),
            "open": 1,
        }
    )


class AltitudeComparator(Unit):
    """Tests one cell per cycle, ``memory_latency + 3`` cycles after it was visited.

    A cell is hit when ``z0 n + k dz <= ground * n``: multiplication and comparison take a cycle
    each, and nothing is rounded.

    Attributes
    ----------
    latency : int
        Cycles from a visit to its test.

    Members
    -------
    visiting : In(1)
    visit : In(visit_layout)
        Cell whose address the memory gets in this cycle.
    level : In(level_layout)
        Altitude of the path at the cell of the previous cycle.
    ground : In(altitude_bits)
        Altitude of the cell visited ``memory_latency + 1`` cycles ago, from a register.
    drop : In(1)
        Discard cells visited after the tested one, including this cycle's.
    valid : Out(1)
    tested : Out(tested_layout)
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1, text="The top altitude marks ground that no path may cross.")
    segment_bits: Width(1, text="Number of a segment in its path.")
    memory_latency: Count(1, 2, "Cycles from an address to its data.")

    def interface(self):
        self.latency = self.memory_latency + 3
        return {
            "visiting": In(1),
            "visit": In(visit_layout(self.coordinate_bits, self.segment_bits)),
            "level": In(level_layout(self.coordinate_bits, self.altitude_bits)),
            "ground": In(self.altitude_bits),
            "drop": In(1),
            "valid": Out(1),
            "tested": Out(tested_layout(self.coordinate_bits, self.segment_bits, self.latency)),
        }

    def elaborate(self, platform):
        m = Module()

        # The youngest first: the cell of this cycle, then those in the pipeline.
        valids, visits = [self.visiting], [self.visit]
        for stage in range(1, self.latency + 1):
            valid = Signal(name=f"valid_{stage}")
            visit = Signal.like(self.visit, name=f"visit_{stage}", reset_less=True)
            m.d.sync += [valid.eq(valids[-1] & ~self.drop), visit.eq(visits[-1])]
            valids.append(valid)
            visits.append(visit)

        def later(value, cycles, name):
            for cycle in range(cycles):
                register = Signal.like(value, name=f"{name}_{cycle}", reset_less=True)
                m.d.sync += register.eq(value)
                value = register
            return value

        steps = later(self.level.steps, self.memory_latency, "steps")
        scaled = later(self.level.scaled, self.memory_latency + 1, "scaled")
        scaled_ground = Signal(self.level.scaled.shape(), reset_less=True)
        top = later(self.ground == (1 << self.altitude_bits) - 1, 1, "top")
        m.d.sync += [
            scaled_ground.eq(self.ground * steps),
            self.tested.hit.eq(scaled <= scaled_ground),
            self.tested.blocked.eq(top),
        ]

        m.d.comb += [self.valid.eq(valids[-1]), self.tested.visit.eq(visits[-1])]
        ended = visits[-1].ends_path
        later_reads = []
        for valid, visit in zip(reversed(valids[:-1]), reversed(visits[:-1]), strict=True):
            later_reads.append(valid & ~ended)
            ended = ended | (valid & visit.ends_path)
        m.d.comb += [
            self.tested.reads.eq(sum(later_reads)),
            # The cell of this cycle does not count: if its path ends now, a drop is still right.
            self.tested.open.eq(
                ~Cat(v & c.ends_path for v, c in zip(valids[1:], visits[1:], strict=True)).any()
            ),
        ]

        return m
