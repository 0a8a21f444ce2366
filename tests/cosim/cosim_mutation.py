# amaranth: UnusedElaboratable=no
"""The exported mutation unit against the model."""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge
from cocotb.utils import get_sim_time

from pathgene.hdl.config import CheckerBuild, Config, MutationKind
from pathgene.hdl.ga_core.mutation import Mutation
from pathgene.hdl.protocol.breeding import crossover
from pathgene.sim.model.mutation import Limits
from pathgene.sim.model.mutation import Mutation as Model
from pathgene.sim.model.selection import Draws


TOP = "mutation"
CONFIG = Config(checker=CheckerBuild.NONE)

UNIT = Mutation(CONFIG)
CLOCK_NS = 10


def random_draws(rng):
    """Return random draws, many of them at the ends of their ranges."""

    def offset(box):
        return rng.choice((-box, box, rng.randint(-box, box)))

    boxes = (CONFIG.box_cells, CONFIG.box_cells, CONFIG.box_steps)
    return Draws(
        parents=(),
        survivors=(),
        children=tuple(rng.sample(range(CONFIG.children), CONFIG.mutators)),
        waypoints=tuple(
            rng.choice((0, 0xFFFF, rng.getrandbits(16))) for _ in range(CONFIG.mutators)
        ),
        offsets=tuple(tuple(map(offset, boxes)) for _ in range(CONFIG.patches)),
    )


def drive(dut, name, value):
    """Set an input to ``value``, given in the input's shape."""
    shape = UNIT.signature.members[name].shape
    getattr(dut, name).value = shape.const(value).as_value().value


@cocotb.test()
async def random_generations(dut):
    """Compare plans, patches and cycles, on shortest, longest and random paths."""
    rng = random.Random(1)
    for name in ("start", "clear", "carrying", "on"):
        getattr(dut, name).value = 0
    dut.rst.value = 1
    Clock(dut.clk, CLOCK_NS, unit="ns").start()
    await FallingEdge(dut.clk)
    dut.rst.value = 0

    refused = set()
    for number in range(120):
        length = {0: CONFIG.MIN_WAYPOINTS, 1: CONFIG.max_waypoints}.get(number % 10)
        parents = [
            [
                rng.getrandbits(CONFIG.waypoint_bits)
                for _ in range(length or rng.randint(CONFIG.MIN_WAYPOINTS, CONFIG.max_waypoints))
            ]
            for _ in range(CONFIG.crossovers)
        ]
        limits = Limits(
            rng.randrange(CONFIG.map_size),
            rng.randrange(CONFIG.map_size),
            rng.randrange(CONFIG.blocked_altitude),
        )
        draws = random_draws(rng)
        expected = Model(CONFIG).mutate(crossover(parents), draws, limits)
        refused |= {mutated.kind for mutated in expected if not mutated.applied}

        drive(dut, "children", draws.children)
        drive(dut, "draws", draws.waypoints)
        axes = ("x", "y", "altitude")
        drive(dut, "offsets", [dict(zip(axes, each, strict=True)) for each in draws.offsets])
        drive(dut, "limits", {"x": limits.x, "y": limits.y, "altitude": limits.altitude})
        for i, path in enumerate(parents):
            getattr(dut, f"lengths__{i}").value = len(path)
        dut.start.value = 1
        begun = get_sim_time("ns")
        await FallingEdge(dut.clk)
        dut.start.value = 0
        await RisingEdge(dut.planned)
        await FallingEdge(dut.clk)
        assert get_sim_time("ns") - begun == CLOCK_NS * UNIT.latency

        dut.carrying.value = 1
        for position in range(max(map(len, parents))):
            dut.position.value = position
            for i, path in enumerate(parents):
                waypoint = path[position] if position < len(path) else 0
                getattr(dut, f"waypoints__{i}").value = waypoint
            await FallingEdge(dut.clk)
        dut.carrying.value = 0

        dut.on.value = 1
        await FallingEdge(dut.clk)
        assert dut.done.value
        await FallingEdge(dut.clk)
        dut.on.value = 0

        for i, mutated in enumerate(expected):
            layout = UNIT.signature.members["mutations"].shape
            done = layout.from_bits(getattr(dut, f"mutations__{i}").value.to_unsigned())
            assert (done.applied, done.child, done.index) == (
                mutated.applied,
                mutated.child,
                mutated.index,
            )
            if mutated.kind is not MutationKind.DELETE:
                assert getattr(dut, f"patches__{i}").value.to_unsigned() == mutated.waypoint
        assert dut.refused.value.to_unsigned() == sum(not each.applied for each in expected)
    assert refused == {MutationKind.INSERT, MutationKind.DELETE}
