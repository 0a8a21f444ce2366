"""Comparison of a path's exact altitude with the ground, cell by cell."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config
from hdl.feasibility.two_tier.cell_walker import level_layout, visit_layout


__all__ = ["AltitudeCompare", "tested_layout"]


def tested_layout(config: Config) -> data.StructLayout:
    """Return the layout of a cell that has been compared.

    ``hit``: the path is not above its ground. ``blocked``: no path may cross that ground.
    ``reads``: addresses of the same path given to a memory since, that of this cycle included.
    ``open``: neither this nor any of those is the path's last cell.
    """
    return data.StructLayout(
        {
            "visit": visit_layout(config),
            "hit": 1,
            "blocked": 1,
            "reads": range(AltitudeCompare.latency_of(config) + 1),
            "open": 1,
        }
    )


class AltitudeCompare(wiring.Component):
    """Tests one cell a cycle, ``memory_latency + 3`` cycles after it was visited.

    A cell is hit when ``z0 n + k dz <= ground * n``: multiplication and comparison take a cycle
    each, and nothing is rounded.

    Parameters
    ----------
    config : Config

    Members
    -------
    visiting : In(1)
    visit : In(visit_layout)
        Cell whose address the memory gets in this cycle.
    level : In(level_layout)
        Altitude of the path at the cell of the cycle before.
    ground : In(altitude_bits)
        Altitude of the cell visited ``memory_latency + 1`` cycles ago, from a register.
    drop : In(1)
        Discard cells visited after the tested one, that of this cycle included.
    valid : Out(1)
    tested : Out(tested_layout)
    """

    @staticmethod
    def latency_of(config: Config) -> int:
        """Return the cycles from a visit to its test."""
        return config.memory_latency + 3

    def __init__(self, config):
        self.config = config
        super().__init__(
            {
                "visiting": In(1),
                "visit": In(visit_layout(config)),
                "level": In(level_layout(config)),
                "ground": In(config.altitude_bits),
                "drop": In(1),
                "valid": Out(1),
                "tested": Out(tested_layout(config)),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config

        # The youngest first: the cell of this cycle, then those in the pipeline.
        valids, visits = [self.visiting], [self.visit]
        for stage in range(1, self.latency_of(config) + 1):
            valid = Signal(name=f"valid_{stage}")
            visit = Signal(visit_layout(config), name=f"visit_{stage}", reset_less=True)
            m.d.sync += [valid.eq(valids[-1] & ~self.drop), visit.eq(visits[-1])]
            valids.append(valid)
            visits.append(visit)

        def later(value, cycles, name):
            for cycle in range(cycles):
                register = Signal.like(value, name=f"{name}_{cycle}", reset_less=True)
                m.d.sync += register.eq(value)
                value = register
            return value

        steps = later(self.level.steps, config.memory_latency, "steps")
        scaled = later(self.level.scaled, config.memory_latency + 1, "scaled")
        scaled_ground = Signal(self.level.scaled.shape(), reset_less=True)
        top = later(self.ground == config.blocked_altitude, 1, "top")
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
