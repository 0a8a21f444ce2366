"""The exported frame receiver against the model, at a byte per cycle and with pauses."""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, ReadOnly

from pathgene.hdl.config import Config
from pathgene.hdl.link.frame import body_layout
from pathgene.hdl.protocol import StickyError
from pathgene.hdl.protocol.codec import encode_frame
from pathgene.sim.model.frames import FrameReceiverModel
from tests.support.gateware.faults import ByteFaults


TOP = "frame_receiver"
CONFIG = Config(receive_buffer=512)


class Bench:
    """Driver that sets inputs at falling edges and samples before rising ones."""

    def __init__(self, dut, pauses):
        self.dut = dut
        self.pauses = pauses
        self.frames = []
        self.verdicts = []
        self._body = bytearray()
        self._wait = 0
        self._idle = 0
        self._kinds = {
            dut.malformed: StickyError.MALFORMED,
            dut.crc_error: StickyError.CRC,
            dut.overrun: StickyError.OVERRUN,
        }
        for port in (dut.rst, dut.bytes__valid, dut.bytes__payload, dut.requests__ready):
            port.value = 0
        Clock(dut.clk, 10, unit="ns").start()

    async def cycle(self, value=None):
        """Pass a cycle; ``value`` is a byte for the receiver or None."""
        dut = self.dut
        dut.bytes__valid.value = value is not None
        dut.bytes__payload.value = value or 0
        dut.requests__ready.value = self._wait == 0
        await ReadOnly()
        assert dut.bytes__ready.value
        self.verdicts += [kind for pulse, kind in self._kinds.items() if pulse.value]
        self._idle += 1
        if dut.requests__valid.value:
            self._idle = 0
        if self._wait:
            self._wait -= 1
        elif dut.requests__valid.value:
            self._take(body_layout.from_bits(dut.requests__payload.value.to_unsigned()))
            self._wait = next(self.pauses)
        await FallingEdge(dut.clk)

    def _take(self, word):
        self._body.append(word.data)
        if word.last:
            self.frames.append((bytes(self._body), bool(word.plain)))
            self._body.clear()

    async def feed(self, data, gap):
        """Send bytes with ``gap`` idle cycles between them."""
        for value in data:
            await self.cycle(value)
            for _ in range(gap):
                await self.cycle()

    async def settle(self):
        """Wait until the receiver has offered all bodies."""
        self._idle = 0
        while self._idle < 16:
            await self.cycle()


@cocotb.test()
@cocotb.parametrize((("gap", "longest_pause"), [(0, 0), (3, 2)]))
async def frames_and_garbage(dut, gap, longest_pause):
    """Match the model's bodies and verdicts on frames, faults and random bytes."""
    rng = random.Random(5)
    pauses = random.Random(6)
    bench = Bench(dut, iter(lambda: pauses.randrange(longest_pause + 1), None))
    model = FrameReceiverModel(CONFIG)
    faults = ByteFaults(2e-3, random.Random(4))
    await FallingEdge(dut.clk)
    for length in (3, 4, 250, 252, 511, 512, 5):
        body = bytes(rng.choice((0, *range(1, 256))) for _ in range(length))
        for plain in (False, True):
            frame = encode_frame(body, plain=plain)
            data = frame + faults(frame) + b"\0" + rng.randbytes(length // 8) + b"\0"
            expected = model.feed(data)
            known = len(bench.frames)
            await bench.feed(data, gap)
            await bench.settle()
            assert bench.frames[known:] == expected
    assert bench.verdicts == model.verdicts
    assert set(model.verdicts) == {StickyError.MALFORMED, StickyError.CRC, StickyError.OVERRUN}
    await bench.feed(b"\0" + encode_frame(b"done"), gap)
    await bench.settle()
    assert bench.frames[-1] == (b"done", False)
