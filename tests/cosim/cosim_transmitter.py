"""The exported reply transmitter: bodies of every kind, at the widths of the default chip."""

import itertools
import random
import zlib

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge
from drivers import Stream

from pathgene.hdl.command.layouts import AnswerKind, answer_layout
from pathgene.hdl.command.transmitter import ReplyTransmitter
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.layouts import record_layout, result_read_layout
from pathgene.hdl.link.frame import body_layout
from pathgene.hdl.protocol import (
    Layout,
    Status,
    check_reply,
    counters_reply,
    info_reply,
    info_values,
    pack_paths,
    recipe_reply,
    status_reply,
    survivors_reply,
)
from tests.support.gateware.chips import random_paths


TOP = "transmitting"
CONFIG = Config(checker=CheckerBuild.PARALLEL)

UNIT = ReplyTransmitter(CONFIG)
RECIPE = Layout(recipe_reply(CONFIG).fields[:-1])
KEPT = CONFIG.elites + CONFIG.survivors


def packed(layout, values):
    """Return the bits of a port of ``layout``."""
    return layout.const(values).as_value().value


class Bench:
    """Driver that sets random registers and paths, and predicts the replies."""

    def __init__(self, dut, *, stalled):
        self.dut = dut
        self.rng = random.Random(3)
        pauses = (lambda: self.rng.choice((0, 0, 1, 5))) if stalled else (lambda: 0)
        self.replies = Stream(dut, "replies", body_layout, dut.clk, pauses)
        self.replies.idle(driven=False)
        self.reads = Stream(dut, "reads", UNIT.read_layout, dut.clk, pauses)
        self.reads.idle(driven=False)
        self.waypoints = Stream(dut, "waypoints", UNIT.waypoint_layout, dut.clk, pauses)
        self.waypoints.idle(driven=True)
        self.result_reads = Stream(dut, "result_reads", result_read_layout, dut.clk, pauses)
        self.result_reads.idle(driven=False)
        self.records = Stream(dut, "records", record_layout, dut.clk, pauses)
        self.records.idle(driven=True)
        self.asked = []
        dut.on.value = 0
        self.draw()

    async def reset(self):
        self.dut.rst.value = 1
        Clock(self.dut.clk, 10, unit="ns").start()
        await FallingEdge(self.dut.clk)
        await FallingEdge(self.dut.clk)
        self.dut.rst.value = 0
        cocotb.start_soon(self._read_out())
        cocotb.start_soon(self._serve_results())

    def draw(self):
        """Set all registers to random values."""
        dut, rng = self.dut, self.rng

        def fields(layout):
            return {name: rng.getrandbits(width) for name, width in layout.fields}

        self.paths = random_paths(CONFIG, rng)
        self.session = rng.randrange(256)
        self.status = fields(status_reply(CONFIG))
        self.counters = fields(counters_reply(CONFIG))
        self.recipe = fields(RECIPE)
        self.totals = fields(check_reply(CONFIG))
        # Results of each path of the latest check; sometimes there was none.
        paths = rng.choice((0, 1, CONFIG.population))
        self.results = [rng.randbytes(rng.randint(1, 80)) for _ in range(paths)]
        self.survivors = [rng.randrange(CONFIG.population) for _ in range(CONFIG.survivors)]
        dut.session.value = self.session
        dut.status.value = packed(UNIT.status_layout, self.status)
        dut.counters.value = packed(UNIT.counters_layout, self.counters)
        dut.recipe.value = packed(UNIT.recipe_layout, self.recipe)
        dut.totals.value = packed(UNIT.totals_layout, self.totals)
        dut.checked.value = len(self.results)
        dut.survivors.value = packed(UNIT.survivors_layout, self.survivors)

    async def _read_out(self):
        while True:
            read = await self.reads.get()
            self.asked.append((read.slot, read.count))
            words = [
                {"waypoint": waypoint, "last": at == len(path) - 1, "final": 0}
                for path in self.paths[read.slot : read.slot + read.count]
                for at, waypoint in enumerate(path)
            ]
            words[-1]["final"] = 1
            await self.waypoints.put(*words)

    async def _serve_results(self):
        while True:
            read = await self.result_reads.get()
            self.asked.append((read.path, read.count))
            data = b"".join(self.results[read.path : read.path + read.count])
            last = len(data) - 1
            await self.records.put(
                *({"data": byte, "last": at == last} for at, byte in enumerate(data))
            )

    def expected(self, kind, slot, count):
        """Return the payload of a reply and the slots that must be read for it."""
        if kind is AnswerKind.INFO:
            payload = info_reply(CONFIG).pack(session=self.session, **info_values(CONFIG))
            return payload, []
        if kind is AnswerKind.STATUS:
            return status_reply(CONFIG).pack(**self.status), []
        if kind is AnswerKind.COUNTERS:
            return counters_reply(CONFIG).pack(**self.counters), []
        if kind is AnswerKind.PATHS:
            return pack_paths(CONFIG, self.paths[slot : slot + count]), [(slot, count)]
        if kind is AnswerKind.CHILDREN:
            named = {f"survivor_{i}": slot for i, slot in enumerate(self.survivors)}
            payload = survivors_reply(CONFIG).pack(**named)
            return payload + pack_paths(CONFIG, self.paths[KEPT:]), [(KEPT, CONFIG.children)]
        if kind is AnswerKind.RECIPE:
            checksum = zlib.crc32(pack_paths(CONFIG, self.paths))
            payload = recipe_reply(CONFIG).pack(**self.recipe, checksum=checksum)
            return payload, [(0, CONFIG.population)]
        if kind in (AnswerKind.TOTALS, AnswerKind.CHECKED):
            payload = check_reply(CONFIG).pack(**self.totals)
            if kind is AnswerKind.TOTALS or not self.results:
                return payload, []
            return payload + b"".join(self.results), [(0, len(self.results))]
        if kind is AnswerKind.RESULTS:
            return b"".join(self.results[slot : slot + count]), [(slot, count)]
        return b"", []

    async def check(self, kind, slot=0, count=0):
        """Compare a reply of the transmitter with the expected one."""
        dut, rng = self.dut, self.rng
        if kind is AnswerKind.RESULTS:  # Requested only if there are results.
            if not self.results:
                return
            slot = rng.randrange(len(self.results))
            count = rng.randint(1, len(self.results) - slot)
        answer = {
            "kind": kind,
            "session": rng.randrange(256),
            "sequence": rng.randrange(256),
            "status": rng.choice(list(Status)) if kind is AnswerKind.EMPTY else Status.OK,
            "plain": kind is AnswerKind.INFO,
            "slot": KEPT if kind is AnswerKind.CHILDREN else slot,
            "count": CONFIG.children if kind is AnswerKind.CHILDREN else count,
        }
        dut.answer.value = packed(answer_layout, answer)
        self.asked.clear()
        dut.on.value = 1
        body = b""
        if kind is not AnswerKind.SILENCE:
            sent = await self.replies.get_until("last")
            body = bytes(byte.data for byte in sent)
            assert {byte.plain for byte in sent} == {answer["plain"]}
        if not dut.done.value:
            await RisingEdge(dut.done)
            await FallingEdge(dut.clk)
        dut.on.value = 0
        await FallingEdge(dut.clk)
        assert not dut.replies__valid.value

        payload, asked = self.expected(kind, slot, count)
        if kind is not AnswerKind.SILENCE:
            payload = bytes(answer[name] for name in ("session", "sequence", "status")) + payload
        assert body == payload
        assert self.asked == asked


@cocotb.test()
@cocotb.parametrize(stalled=[False, True])
async def every_kind_after_every_other(dut, stalled):
    """Send every kind of reply after every other; none affects the next."""
    bench = Bench(dut, stalled=stalled)
    await bench.reset()
    kinds = list(AnswerKind)
    long = (AnswerKind.PATHS, AnswerKind.CHILDREN, AnswerKind.CHECKED, AnswerKind.RESULTS)
    short = [kind for kind in kinds if kind not in long]
    for one, other in [*itertools.product(short, short), *itertools.pairwise(kinds * 2)]:
        for kind in (one, other):
            slot = bench.rng.randrange(CONFIG.population)
            await bench.check(kind, slot, min(CONFIG.population - slot, bench.rng.randint(1, 4)))
        bench.draw()
    await bench.check(AnswerKind.PATHS, 0, CONFIG.population)


@cocotb.test()
async def first_byte_and_rate(dut):
    """Send the first byte 3 cycles after ``on``; every six bytes of fields take one more cycle."""
    bench = Bench(dut, stalled=False)
    await bench.reset()
    dut.answer.value = packed(answer_layout, {"kind": AnswerKind.COUNTERS, "session": 1})
    words = len(counters_reply(CONFIG).fields)
    dut.on.value = 1
    dut.replies__ready.value = 1
    valid = []
    while not dut.done.value:
        valid.append(int(dut.replies__valid.value))
        await FallingEdge(dut.clk)
    assert valid == [0] * 3 + [1] * 3 + ([0] + [1] * 6) * words
    dut.on.value = 0
