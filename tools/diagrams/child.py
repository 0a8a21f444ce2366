"""Waveform of the child builder, which crosses two paths and moves a waypoint."""

from __future__ import annotations

from typing import Any

from amaranth.sim import Simulator

from pathgene.hdl.planner.child_builder import ChildBuilder
from tools.diagrams.waves import Trace, draw, integer


__all__ = ["child_scene"]

#: Waypoints of the parents by slot: x, y, altitude.
_PARENTS = {
    2: [(3, 2, 9), (6, 4, 9), (9, 7, 8)],
    5: [(2, 5, 7), (5, 9, 7), (8, 12, 8), (11, 13, 9)],
}
_START, _GOAL = (0, 0, 9), (15, 15, 9)
#: Slot of the child.
_SLOT = 7
_CYCLES = 18


def child_scene() -> str:
    """Return the SVG: the head of slot 2, the tail of slot 5, and the third waypoint moved."""
    builder = ChildBuilder(
        slot_count=8, max_waypoints=5, coordinate_bits=4, altitude_bits=4, box_cells=4, box_steps=2
    )
    rows: dict[str, Any] = {
        "plans.ready": builder.plans.ready,
        "plans.valid": builder.plans.valid,
        "read.slot": builder.read.slot,
        "read.index": builder.read.index,
        "waypoint.x": builder.waypoint.x,
        "waypoint.y": builder.waypoint.y,
        "write.valid": builder.write.valid,
        "write.slot": builder.write.place.slot,
        "write.index": builder.write.place.index,
        "write.x": builder.write.waypoint.x,
        "write.y": builder.write.waypoint.y,
        "points.valid": builder.points.valid,
        "points.x": builder.points.p.x,
        "points.y": builder.points.p.y,
        "points.last": builder.points.p.last,
    }
    values: dict[str, list[int]] = {label: [] for label in rows}

    async def bench(ctx: Any) -> None:
        names = ("x", "y", "altitude")
        ends = dict(zip(names, _START, strict=True)), dict(zip(names, _GOAL, strict=True))
        limits = {"x": 15, "y": 15, "altitude": 14}
        ctx.set(builder.frame, {"limits": limits, "start": ends[0], "goal": ends[1]})
        ctx.set(builder.slots.payload, _SLOT)
        ctx.set(
            builder.plans.payload,
            {"head_slot": 2, "tail_slot": 5, "head": 2, "length": 4, "place": 3,
             "move": {"x": 2, "y": -3, "altitude": 0}},
        )  # fmt: skip
        for port in (builder.slots.valid, builder.children.ready, builder.points.ready):
            ctx.set(port, 1)
        earlier = None
        taken = False
        for cycle in range(_CYCLES):
            ctx.set(builder.plans.valid, cycle > 0 and not taken)
            taken |= bool(ctx.get(builder.plans.valid & builder.plans.ready))
            for label, signal in rows.items():
                values[label].append(int(ctx.get(signal)))
            read = ctx.get(builder.read)
            await ctx.tick()
            # The population's memory: the waypoint of a read arrives 2 cycles later.
            path = _PARENTS.get(earlier[0], []) if earlier is not None else []
            if earlier is not None and earlier[1] < len(path):
                held = dict(zip(names, path[earlier[1]], strict=True))
                ctx.set(builder.waypoint, {**held, "margin": 0})
            earlier = read.slot, read.index

    simulator = Simulator(builder)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    groups = {"read": "", "waypoint": "", "write": "write.valid", "points": "points.valid"}
    traces = []
    for label, row in values.items():
        group, _, name = label.partition(".")
        is_bit = name in ("valid", "ready", "last")
        chosen = values[groups[group]] if groups.get(group) and not is_bit else []
        traces.append(Trace(label, None if is_bit else integer, row, chosen))
    title = "A child: two waypoints of slot 2, two of slot 5, the third moved by 2 and -3"
    return draw(title, traces, 0, _CYCLES - 1)
