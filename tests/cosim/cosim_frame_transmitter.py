"""The exported frame transmitter against the codec of the host."""

import itertools
import random
from functools import partial

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, ReadOnly

from pathgene.hdl.config import Config
from pathgene.hdl.link.frame import body_layout
from pathgene.hdl.protocol.codec import encode_frame


TOP = "frame_transmitter"
CONFIG = Config()


class Bench:
    """Driver that sets inputs at falling edges and samples before rising ones."""

    def __init__(self, dut, pauses):
        self.dut = dut
        self.sent = bytearray()
        self._pauses = itertools.cycle(pauses)
        self._wait = next(self._pauses)
        for port in (dut.rst, dut.replies__valid, dut.replies__payload, dut.bytes__ready):
            port.value = 0
        Clock(dut.clk, 10, unit="ns").start()

    async def cycle(self, word=None):
        """Pass a cycle; return whether ``word``, a word of a reply or None, was accepted."""
        dut = self.dut
        dut.replies__valid.value = word is not None
        if word is not None:
            dut.replies__payload.value = body_layout.const(word).as_bits()
        dut.bytes__ready.value = self._wait == 0
        await ReadOnly()
        taken = bool(dut.replies__ready.value)
        if self._wait:
            self._wait -= 1
        elif dut.bytes__valid.value:
            self.sent.append(dut.bytes__payload.value.to_unsigned())
            self._wait = next(self._pauses)
        await FallingEdge(dut.clk)
        return taken

    async def until(self, condition, limit=20_000):
        """Await ``condition`` once per cycle until it is true."""
        for _ in range(limit):
            if await condition():
                return
        raise TimeoutError(f"Not within {limit} cycles")


@cocotb.test()
@cocotb.parametrize(pauses=[(0,), (0, 2, 1)], source_pauses=[(0,), (0, 0, 7)])
async def bodies_of_all_lengths(dut, pauses, source_pauses):
    """Send bodies of up to the longest reply, with nonzero runs longer than a COBS block."""
    rng = random.Random(6)
    bench = Bench(dut, pauses)
    between = itertools.cycle(source_pauses)
    expected = b""
    await FallingEdge(dut.clk)
    for length in (3, 4, 249, 250, 251, 252, 506, 900):
        plain = length % 2 == 0
        zeros = rng.choice((0.0, 0.003, 0.2))
        body = bytes(0 if rng.random() < zeros else rng.randrange(1, 256) for _ in range(length))
        expected += encode_frame(body, plain=plain)
        for at, value in enumerate(body):
            for _ in range(next(between)):
                await bench.cycle()
            word = {"data": value, "last": at == length - 1, "plain": plain}
            await bench.until(partial(bench.cycle, word))

    async def all_sent():
        await bench.cycle()
        return len(bench.sent) >= len(expected)

    await bench.until(all_sent)
    assert bytes(bench.sent) == expected
