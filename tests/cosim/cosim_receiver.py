"""The exported command receiver compared with the model: every kind of request, valid or broken."""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge
from drivers import Stream

from pathgene.hdl.command.layouts import AnswerKind, answer_layout
from pathgene.hdl.command.receiver import CommandReceiver
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.link.frame import body_layout
from pathgene.hdl.protocol import (
    CheckFlag,
    Command,
    Counter,
    LinkMode,
    Status,
    StickyError,
    check_paths_request,
    start_request,
)
from pathgene.hdl.protocol.codec import FrameSplitter, decode_frame, encode_frame
from pathgene.sim.model.chip import Chip
from pathgene.sim.model.requests import FrameReceiverModel
from tests.support.gateware.fuzz import Fuzz


TOP = "receiving"
CONFIG = Config(checker=CheckerBuild.PARALLEL, map_size=32, coarse_factor=4)

UNIT = CommandReceiver(CONFIG)
KINDS = {
    Command.STATUS: AnswerKind.STATUS,
    Command.COUNTERS: AnswerKind.COUNTERS,
    Command.READ: AnswerKind.PATHS,
    Command.RESULTS: AnswerKind.RESULTS,
}
GENERATE_KINDS = {
    LinkMode.POPULATION: AnswerKind.PATHS,
    LinkMode.RANK: AnswerKind.CHILDREN,
    LinkMode.RECIPE: AnswerKind.RECIPE,
}


class Bench:
    """Driver of the receiver, in place of the control unit."""

    def __init__(self, dut, *, stalled):
        self.dut = dut
        rng = random.Random(2)
        pauses = (lambda: rng.choice((0, 0, 1, 4))) if stalled else (lambda: 0)
        self.requests = Stream(dut, "requests", body_layout, dut.clk, pauses)
        self.requests.idle(driven=True)
        self.collected = {}
        for name in ("start_requests", "writes", "ranking", "cells", "points"):
            layout = UNIT.signature.members[name].signature.members["payload"].shape
            stream = Stream(dut, name, layout, dut.clk, pauses)
            stream.idle(driven=False)
            self.collected[name] = []
            cocotb.start_soon(self._collect(stream, self.collected[name]))
        dut.on.value = 0
        dut.ranked.value = 1
        dut.line_errors.value = 0
        dut.checked.value = 0

    async def _collect(self, stream, into):
        while True:
            into.append(await stream.get())

    async def reset(self):
        self.dut.rst.value = 1
        Clock(self.dut.clk, 10, unit="ns").start()
        await FallingEdge(self.dut.clk)
        await FallingEdge(self.dut.clk)
        self.dut.rst.value = 0

    async def hand_over(self, body, plain):
        """Pass a body; return the reply, whether a generation is due, and the check or None."""
        dut = self.dut
        for taken in self.collected.values():
            taken.clear()
        dut.on.value = 1
        last = len(body) - 1
        await self.requests.put(
            *({"data": byte, "last": at == last, "plain": plain} for at, byte in enumerate(body))
        )
        if not dut.done.value:
            await RisingEdge(dut.done)
            await FallingEdge(dut.clk)
        generates = bool(dut["generate"].value)
        checks = UNIT.check_layout.from_bits(dut.checks.value.to_unsigned())
        checks = checks if dut.check.value else None
        dut.on.value = 0
        await FallingEdge(dut.clk)
        await FallingEdge(dut.clk)
        return answer_layout.from_bits(dut.answer.value.to_unsigned()), generates, checks


def expected_kind(body, plain, answer):
    """Return the kind of reply that the transmitter must be asked for."""
    if not answer:
        return AnswerKind.SILENCE
    if plain:
        return AnswerKind.INFO
    if answer[2] != Status.OK:
        return AnswerKind.EMPTY
    if body[2] == Command.GENERATE:
        return GENERATE_KINDS[body[3]]
    if body[2] in (Command.CHECK, Command.CHECK_PATHS):
        flags = body[3] if body[2] == Command.CHECK else body[5]
        return AnswerKind.TOTALS if flags & CheckFlag.BRIEF else AnswerKind.CHECKED
    return KINDS.get(body[2], AnswerKind.EMPTY)


@cocotb.test()
@cocotb.parametrize(stalled=[False, True])
async def random_requests(dut, stalled):
    """Match the model's statuses, requests to the core and sticky errors."""
    bench = Bench(dut, stalled=stalled)
    await bench.reset()
    fuzz = Fuzz(CONFIG, seed=4 + stalled)
    receiver = FrameReceiverModel(CONFIG)
    model = Chip(CONFIG)
    refused = runs = generations = checks_done = session = expected = 0
    sticky = StickyError(0)
    while fuzz.frames < 300:
        batch, _, _ = fuzz.batch()
        for body, plain in receiver.feed(batch):
            paths = [list(path) for path in model.core.paths]
            generation = model.core.generation
            heights = model.checking.terrain.heights.copy()
            checked = model.checking.counters[Counter.PATHS]
            dut.checked.value = model.checking.checked
            answer = b""
            for encoded in FrameSplitter().feed(model.feed(encode_frame(body, plain=plain))):
                answer, _ = decode_frame(encoded)
            told, generates, checks = await bench.hand_over(body, plain)

            kind = expected_kind(body, plain, answer)
            assert told.kind == kind, (body, kind)
            if kind is not AnswerKind.SILENCE:
                assert bytes((told.session, told.sequence, told.status)) == answer[:3], body
                assert told.plain == plain
            if (kind is AnswerKind.PATHS and body[2] == Command.READ) or kind is AnswerKind.RESULTS:
                assert bytes((told.slot, told.count)) == body[3:]
            elif kind is AnswerKind.PATHS:
                assert (told.slot, told.count) == (0, CONFIG.population)
            elif kind is AnswerKind.CHILDREN:
                assert (told.slot, told.count) == (10, 22)

            executed = not plain and answer[2] == Status.OK and body[1] == expected
            started = executed and body[2] == Command.START
            assert len(bench.collected["start_requests"]) == started, body
            runs += started
            executes = model.core.generation > generation
            generations += executes
            assert generates == executes, body
            check_orders(bench.collected, body, answer, generates)
            for cell in bench.collected["cells"]:
                heights[cell.y, cell.x] = cell.altitude
            assert (heights == model.checking.terrain.heights).all(), body
            assert [cell.last for cell in bench.collected["cells"]][-1:] in ([], [1])
            paths_checked = model.checking.counters[Counter.PATHS] - checked
            assert (checks is not None) == (paths_checked > 0), body
            if checks is not None:
                check_checks(checks, bench.collected["points"], body, paths_checked)
                checks_done += 1
            if body[2] == Command.WRITE and answer[2:3] == bytes((Status.OK,)):
                assert written(bench.collected["writes"], paths) == model.core.paths

            if not plain and answer[2] == Status.OK:
                if body[2] == Command.OPEN:
                    session, expected = body[0], expected if body[0] == session else 0
                elif body[1] == expected:
                    expected = (expected + 1) % 256
                    sticky = StickyError(0) if body[2] == Command.CLEAR else sticky
            elif not plain and answer[2] >= Status.UNKNOWN_COMMAND:
                sticky |= StickyError.REFUSED
                refused += 1
            assert dut.errors.value.to_unsigned() == sticky.value
            assert dut.session.value.to_unsigned() == session
    assert refused > 5
    assert runs > 3
    assert generations > 20
    assert checks_done > 10
    assert session > 0


def check_orders(collected, body, answer, generates):
    """Assert that START reaches the core with its values and GENERATE with its ranking."""
    accepted = answer[2:3] == bytes((Status.OK,))
    requests = [
        (each.seed, each.x, each.y, each.altitude, each.avoid_ground)
        for each in collected["start_requests"]
    ]
    if requests:
        values = start_request(CONFIG).unpack(body[3:])
        assert accepted
        assert requests == [tuple(values.values())]
    if generates:
        order = list(body[4:]) or list(range(CONFIG.population))
        assert [(r.rank, r.slot) for r in collected["ranking"]] == list(enumerate(order))
    elif accepted:
        assert collected["ranking"] == []


def check_checks(checks, points, body, paths):
    """Assert that a check has the points or slots and the counting of the request."""
    assert checks.batch == (body[2] == Command.CHECK_PATHS)
    if checks.batch:
        asked = check_paths_request(CONFIG).unpack(body[3:])
        assert checks.counting == asked.pop("flags") & CheckFlag.COUNT
        assert {name: checks[name] for name in asked} == asked
        assert checks.count == paths
    else:
        assert checks.counting == body[3] & CheckFlag.COUNT
        packed = [UNIT.point_layout.const(point).as_value().value for point in points]
        size, last = CONFIG.waypoint_bytes, 1 << CONFIG.waypoint_bits
        assert b"".join(word.to_bytes(size, "little") for word in packed) == body[4:]
        assert [bool(word & last) for word in packed] == [False] * (len(packed) - 1) + [True]


def written(writes, paths):
    """Return ``paths`` after ``writes``."""
    paths = [list(path) for path in paths]
    path = []
    for word in writes:
        assert word.index == len(path)
        path.append(word.waypoint)
        if word.last:
            paths[word.slot] = path
            path = []
    assert path == []
    return paths


@cocotb.test()
async def line_errors_stick(dut):
    """Keep every error of the line, and a refusal, until CLEAR."""
    bench = Bench(dut, stalled=False)
    await bench.reset()
    for number, error in enumerate(list(StickyError)[:4]):
        dut.line_errors.value = 1 << number
        await FallingEdge(dut.clk)
        dut.line_errors.value = 0
        await FallingEdge(dut.clk)
        assert dut.errors.value.to_unsigned() == error.value
        if error is StickyError.CRC:
            await bench.hand_over(bytes((0, number, 99)), False)
            assert dut.errors.value.to_unsigned() == (error | StickyError.REFUSED).value
        await bench.hand_over(bytes((0, number, Command.CLEAR)), False)
        assert dut.errors.value == 0
