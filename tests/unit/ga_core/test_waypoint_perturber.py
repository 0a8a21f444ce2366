"""The perturber of waypoints on a chip without a map."""

import itertools
import random

from pathgene.hdl.ga_core.layouts import limits_layout, offset_layout
from pathgene.hdl.ga_core.mutator import WaypointPerturber
from pathgene.sim.model.mutation import clamp
from tests.support.gateware.streams import simulate


AXES = ("x", "y", "altitude")
SIZES = {
    "crossovers": 3,
    "max_waypoints": 5,
    "limits_layout": limits_layout(4, 5),
    "offset_layout": offset_layout(box_cells=6, box_steps=20),
}


def test_moves_the_waypoint_of_its_plan_within_the_limits():
    """Every parent and position, 2 cycles after the last waypoint at the earliest."""
    dut = WaypointPerturber(**SIZES)
    axes = SIZES["limits_layout"]

    async def bench(ctx):
        rng = random.Random(1)
        for parent, position in itertools.product(range(3), range(5)):
            limits = {"x": rng.randrange(16), "y": rng.randrange(16), "altitude": rng.randrange(32)}
            offset = {
                "x": rng.randint(-6, 6),
                "y": rng.randint(-6, 6),
                "altitude": rng.randint(-20, 20),
            }
            ctx.set(dut.plan, {"parent": parent, "position": position})
            ctx.set(dut.limits, limits)
            ctx.set(dut.offset, offset)
            paths = [[rng.getrandbits(axes.size) for _ in range(5)] for _ in range(3)]
            ctx.set(dut.carrying, 1)
            for passing in range(5):
                ctx.set(dut.position, passing)
                for port, path in zip(dut.waypoints, paths, strict=True):
                    ctx.set(port, path[passing])
                await ctx.tick()
            ctx.set(dut.carrying, 0)
            # Without `carrying`, nothing passes.
            ctx.set(dut.position, position)
            await ctx.tick()
            base = axes.from_bits(paths[parent][position])
            moved = axes.from_bits(ctx.get(dut.moved))
            for axis in AXES:
                assert moved[axis] == clamp(base[axis] + offset[axis], limits[axis])

    simulate(dut, bench)
