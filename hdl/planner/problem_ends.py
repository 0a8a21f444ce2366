"""Corners of the two ends of a problem."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config
from hdl.planner.layouts import problem_layout
from hdl.planner.population_layouts import corner_layout
from hdl.protocol.planner import ALTITUDE_FRACTION, POSITION_FRACTION


__all__ = ["ProblemEnds"]


class ProblemEnds(wiring.Component):
    """Gives the corners nearest to start and goal, and the steps at or below them.

    The corners are within the limits of the problem. They follow it by a cycle. Equals
    :func:`sim.model.planner.definition.score.corner_of`.

    Parameters
    ----------
    config : Config

    Members
    -------
    problem : In(problem_layout)
    start, goal, limits : Out(corner_layout)
        The two corners, and the greatest corner and altitude of a waypoint.
    """

    def __init__(self, config: Config):
        self.config = config
        corner = corner_layout(config.coordinate_bits, config.altitude_bits)
        super().__init__(
            {
                "problem": In(problem_layout(config)),
                "start": Out(corner),
                "goal": Out(corner),
                "limits": Out(corner),
            }
        )

    def elaborate(self, platform):
        m = Module()

        problem = self.problem
        for axis in ("x", "y", "altitude"):
            m.d.sync += self.limits[axis].eq(problem[f"{axis}_limit"])
        for end in ("start", "goal"):
            corner = getattr(self, end)
            altitude = problem[f"{end}_altitude"]
            m.d.sync += corner.altitude.eq(altitude >> ALTITUDE_FRACTION)
            for axis in "xy":
                limit = problem[f"{axis}_limit"]
                half = 1 << POSITION_FRACTION - 1
                nearest = (problem[f"{end}_{axis}"] + half) >> POSITION_FRACTION
                m.d.sync += corner[axis].eq(Mux(nearest > limit, limit, nearest))

        return m
