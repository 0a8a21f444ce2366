"""Waveforms of the small chip: a framed command, a generation and a check."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from amaranth.hdl import Value
from amaranth.lib import data
from amaranth.sim import Simulator

from pathgene.hdl.planner.child_builder import ChildBuilder
from pathgene.hdl.protocol.codec import encode_frame
from pathgene.hdl.protocol.codes import ChipState, Command, LinkMode
from pathgene.hdl.protocol.messages import (
    check_request,
    generate_request,
    map_request,
    start_request,
    write_request,
)
from pathgene.hdl.protocol.paths import pack_cells, pack_paths
from tools.diagrams.blocks import Unit
from tools.diagrams.waves import Trace, draw, hexadecimal, integer, text_of
from tools.protocol_page.frames import SMALL


#: Titles of the waveforms and their rows, by the name of the file in docs/pictures.
_SCENES = {
    "command": (
        "OPEN of session 1 and its reply at the pins",
        *("rx", "bytes of rx", "state", "tx", "bytes of tx"),
    ),
    "command_inside": (
        "The same inside the chip, after the last bit of the request",
        *("rx", "requests.valid", "requests.data", "state", "receiver.on"),
        *("replies.valid", "replies.data", "tx"),
    ),
    "generation": (
        "One generation with a map: crossover, new waypoints against the ground, update",
        *("state", "carrying", "position", "waypoints[0].x", "waypoints[0].y"),
        *("lookup_valid", "lookup_x", "lookup_y", "lookup_altitude", "update"),
    ),
    "check": (
        "One CHECK: four points in, cells step by step, a hit in the second segment",
        *("state", "points.valid", "points.ready", "points.x", "points.y", "points.altitude"),
        *("step.valid", "step.segment", "step.cells", "step.hit"),
        *("verdicts.valid", "verdicts.collision", "verdicts.x", "verdicts.y"),
    ),
}
#: Rows that mark the values of other rows, besides ``valid`` of a stream.
_VALID = {
    **dict.fromkeys(("position", "waypoints[0].x", "waypoints[0].y"), "carrying"),
    **dict.fromkeys(("lookup_x", "lookup_y"), "lookup_valid"),
}
#: Rows with values in words.
_SHOWN = {"state": text_of(ChipState)}
#: Maximum cycles of a command.
_LIMIT = 20_000


class Recording:
    """A simulated chip that is driven at its pins, with recorded signals by label."""

    def __init__(self, top: Unit, rows: dict[str, Any]) -> None:
        self.values: dict[str, list[int]] = {label: [] for label in rows}
        #: First and last cycle of each frame's command.
        self.spans: list[tuple[int, int]] = []
        self._top, self._rows = top, rows
        self._sending = top.find("Line").component.sending

    def run(self, frames: Sequence[tuple[bytes, bool]]) -> None:
        """Send each frame after the reply to the previous one; record the marked frames."""
        simulator = Simulator(self._top.fragment)

        async def bench(ctx: Any) -> None:
            ctx.set(self._top.component.rx, 1)
            await self._cycles(ctx, 12, recorded=False)
            for frame, recorded in frames:
                await self._exchange(ctx, frame, recorded)

        simulator.add_testbench(bench)
        simulator.run()

    async def _exchange(self, ctx: Any, frame: bytes, recorded: bool) -> None:
        first = self._count
        for byte in frame:
            for bit in _bits(byte):
                ctx.set(self._top.component.rx, bit)
                await self._cycles(ctx, SMALL.clocks_per_bit, recorded=recorded)
        replied = False
        for _ in range(_LIMIT):
            await self._cycles(ctx, 1, recorded=recorded)
            replied |= ctx.get(self._sending)
            if replied and not ctx.get(self._sending):
                break
        else:
            raise TimeoutError(f"Command not done in {_LIMIT} cycles")
        await self._cycles(ctx, 16, recorded=recorded)
        if recorded:
            self.spans.append((first, self._count - 1))

    @property
    def _count(self) -> int:
        return len(next(iter(self.values.values())))

    async def _cycles(self, ctx: Any, count: int, *, recorded: bool) -> None:
        clock = self._top.component.clk
        for _ in range(count):
            if recorded:
                for label, signal in self._rows.items():
                    self.values[label].append(int(ctx.get(signal)))
            ctx.set(clock, 1)
            await ctx.delay(5e-9)
            ctx.set(clock, 0)
            await ctx.delay(5e-9)

    def bytes_of(self, label: str) -> Trace:
        """Return a row of the bytes on a UART line, each from start bit to stop bit."""
        line = self.values[label]
        width = SMALL.clocks_per_bit
        trace = Trace(f"bytes of {label}", hexadecimal, [0] * len(line), [0] * len(line))
        cycle = 0
        while cycle + 10 * width <= len(line):
            if line[cycle]:
                cycle += 1
                continue
            bits = [line[cycle + width * bit + width // 2] for bit in range(1, 9)]
            span = slice(cycle, cycle + 10 * width)
            trace.values[span] = [sum(bit << i for i, bit in enumerate(bits))] * (10 * width)
            # The last cycle separates equal bytes.
            trace.valid[span] = [1] * (10 * width - 1) + [0]
            cycle += 10 * width
        return trace

    def trace(self, label: str) -> Trace:
        """Return a row of a picture: of a recorded signal, or ``bytes of`` one."""
        if label.startswith("bytes of "):
            return self.bytes_of(label.removeprefix("bytes of "))
        return _trace(label, self._rows, self.values)

    def around(self, label: str, after: int, before: int, after_it: int) -> tuple[int, int]:
        """Return the span of a row's first run of ones after cycle ``after``, with margins."""
        high = [cycle for cycle, value in enumerate(self.values[label]) if value]
        run = [cycle for cycle in high if cycle >= after]
        last = run[0]
        while last + 1 in run:
            last += 1
        return run[0] - before, last + after_it


def scenes(top: Unit) -> dict[str, str]:
    """Return the SVGs of the waveforms by name."""
    recording = Recording(top, _rows(top))
    recording.run(_frames())
    begins = [first for first, _ in recording.spans]
    spans = {
        "command": recording.spans[0],
        "command_inside": recording.around("requests.valid", begins[0], 6, 16),
        "generation": recording.around("generating", begins[1], 4, 6),
        "check": recording.around("checking", begins[2], 4, 6),
    }
    return {
        name: draw(title, [recording.trace(label) for label in labels], *spans[name])
        for name, (title, *labels) in _SCENES.items()
    }


def _rows(top: Unit) -> dict[str, Any]:
    line, control = top.find("Line").component, top.find("Control").component
    population, core = top.find("Population").component, top.find("PaperCore").component
    checker = top.find("Checker").component
    walker = top.find("ParallelWalker").component
    receiver = top.find("CommandReceiver").component
    waypoint = data.View(_waypoint(), population.waypoints[0])
    state = Value.cast(control.state)
    running = (ChipState.CROSSOVER, ChipState.MUTATE, ChipState.UPDATE)
    return {
        "rx": line.rx,
        "requests.valid": line.requests.valid,
        "requests.data": line.requests.p.data,
        "receiver.on": receiver.on,
        "state": state,
        "replies.valid": line.replies.valid,
        "replies.data": line.replies.p.data,
        "tx": line.tx,
        "generating": sum((state == value for value in running), start=state == 255),
        "carrying": population.carrying,
        "position": population.position,
        "waypoints[0].x": waypoint.x,
        "waypoints[0].y": waypoint.y,
        "lookup_valid": core.lookup_valid,
        "lookup_x": core.lookup_x,
        "lookup_y": core.lookup_y,
        "lookup_altitude": core.lookup_altitude,
        "update": population.update,
        "checking": state == ChipState.CHECK,
        "points.valid": checker.points.valid,
        "points.ready": checker.points.ready,
        "points.x": checker.points.p.x,
        "points.y": checker.points.p.y,
        "points.altitude": checker.points.p.altitude,
        "step.valid": walker.step.valid,
        "step.segment": walker.step.segment,
        "step.cells": walker.step.cells,
        "step.hit": walker.step.hit,
        "verdicts.valid": checker.verdicts.valid,
        "verdicts.collision": checker.verdicts.p.collision,
        "verdicts.x": checker.verdicts.p.x,
        "verdicts.y": checker.verdicts.p.y,
    }


def _waypoint() -> data.StructLayout:
    return data.StructLayout(
        {"x": SMALL.coordinate_bits, "y": SMALL.coordinate_bits, "altitude": SMALL.altitude_bits}
    )


def _frames() -> list[tuple[bytes, bool]]:
    """Return every frame, with a flag that marks frames to record."""
    bits, edge = SMALL.coordinate_bits, SMALL.map_size - 1
    paths = [
        [
            (2 + slot + step) % 16 | (3 * slot + 2 * step) % 16 << bits | 9 << 2 * bits
            for step in range(2 + slot % 4)
        ]
        for slot in range(SMALL.population)
    ]
    # A ridge from south to north with a gap, in which one cell is too high.
    ridge = map_request(SMALL).pack(x=8, y=0, width=1, height=16)
    ground = [14, 14, 14, 3, 3, 11, 3, 3, 3, 14, 14, 14, 14, 14, 14, 14]
    order = {f"slot_{slot}": slot for slot in range(SMALL.population)}
    points = [x | y << bits | 9 << 2 * bits for x, y in ((2, 2), (7, 5), (10, 6), (13, 12))]
    start = start_request(SMALL).pack(seed=3, x=edge, y=edge, altitude=13, avoid_ground=1)
    rank = generate_request(SMALL, LinkMode.RANK).pack(mode=LinkMode.RANK, **order)
    check = check_request(SMALL).pack(flags=0) + pack_paths(SMALL, [points])
    commands = [
        (Command.START, start, False),
        (Command.MAP, ridge + pack_cells(SMALL, ground), False),
        (Command.WRITE, write_request(SMALL).pack(slot=0) + pack_paths(SMALL, paths), False),
        (Command.GENERATE, rank, True),
        (Command.CHECK, check, True),
    ]
    frames = [(encode_frame(bytes((1, 255, Command.OPEN))), True)]
    for sequence, (command, payload, recorded) in enumerate(commands):
        frames.append((encode_frame(bytes((1, sequence, command)) + payload), recorded))
    return frames


def _bits(byte: int) -> tuple[int, ...]:
    """Return the bits of a byte on the line: start, eight of data, stop."""
    return (0, *(byte >> bit & 1 for bit in range(8)), 1)


def _trace(label: str, signals: dict[str, Any], values: dict[str, list[int]]) -> Trace:
    """Return a row: a bit, or values that are shown while the row that marks them is high."""
    if len(Value.cast(signals[label])) == 1:
        return Trace(label, None, values[label])
    show = hexadecimal if label.endswith(".data") else integer
    valid = _VALID.get(label, f"{label.rpartition('.')[0]}.valid")
    return Trace(label, _SHOWN.get(label, show), values[label], values.get(valid, []))


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
    traces = [_trace(label, rows, values) for label in rows]
    title = "A child: two waypoints of slot 2, two of slot 5, the third moved by 2 and -3"
    return draw(title, traces, 0, _CYCLES - 1)
