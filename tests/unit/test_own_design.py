"""The example of a design with units of this project: it is elaborated, simulated and exported."""

import importlib
import random
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from amaranth import *

from pathgene.hdl.link.uart import Uart
from pathgene.hdl.protocol.codec import FrameSplitter, decode_frame, encode_frame
from tests.support.gateware.streams import put, simulate


ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "own_design.md"
EXAMPLE = ROOT / "examples" / "sorting_service.py"
CLOCKS_PER_BIT = 4
SortingService = runpy.run_path(str(EXAMPLE))["SortingService"]


def answers(bodies, capacity, spoil=()):
    """Return the bodies that the service sends back over a UART."""
    m = Module()
    m.submodules.service = service = SortingService(CLOCKS_PER_BIT, capacity)
    m.submodules.uart = uart = Uart(CLOCKS_PER_BIT)
    m.d.comb += [service.rx.eq(uart.tx), uart.rx.eq(service.tx)]
    frames = [bytearray(encode_frame(body, plain=True)) for body in bodies]
    for number in spoil:
        frames[number][1] ^= 4
    received = bytearray()

    async def send(ctx):
        for value in b"".join(frames):
            await put(ctx, uart.sent, value, 100_000)
        await ctx.tick().repeat(11 * CLOCKS_PER_BIT * (max(map(len, frames)) + 2 * capacity + 40))

    async def collect(ctx):
        ctx.set(uart.received.ready, 1)
        async for *_, valid, value in ctx.tick().sample(uart.received.valid, uart.received.payload):
            if valid:
                received.append(value)

    simulate(m, send, background=[collect])
    splitter = FrameSplitter()
    frames = [decode_frame(frame) for frame in splitter.feed(bytes(received))]
    assert not splitter.inside
    assert all(plain for _, plain in frames)
    return [body for body, _ in frames]


def test_sorts_each_frame():
    rng = random.Random(5)
    bodies = [bytes(rng.randrange(256) for _ in range(length)) for length in (8, 3, 5, 8, 3)]
    bodies += [b"\xff\xff\xff\0", bytes(8)]
    assert answers(bodies, 8) == [bytes(sorted(body)) for body in bodies]


def test_keeps_the_lowest_of_a_long_frame():
    assert answers([bytes(range(20, 0, -1))], 6) == [bytes(range(1, 7))]


def test_discards_a_broken_frame():
    assert answers([b"cba", b"fed", b"ihg"], 4, spoil=[1]) == [b"abc", b"ghi"]


@pytest.mark.parametrize(
    ("sizes", "message"),
    [
        ((3, 64), "Clocks per bit must be from 4 to 65535, not 3"),
        ((4, 251), "Capacity must be from 3 to 250, not 251"),
    ],
)
def test_parameters_are_checked(sizes, message):
    with pytest.raises(ValueError, match=f"^{message}$"):
        SortingService(*sizes)


def test_exports_verilog(tmp_path):
    target = tmp_path / "service.v"
    subprocess.run([sys.executable, EXAMPLE, target], check=True, cwd=EXAMPLE.parents[1])
    assert "module sorting_service" in target.read_text("utf-8")


def test_the_table_names_units_of_the_gateware():
    """The first name of a row has its module; further names are of the same module."""
    rows = re.findall(r"^\| (`[a-z_]+\..*?`) \|", PAGE.read_text(), re.MULTILINE)
    assert len(rows) > 8
    for row in rows:
        first, *others = re.findall(r"`([\w.]+)`", row)
        module, _, name = first.rpartition(".")
        units = vars(importlib.import_module(f"pathgene.hdl.{module}"))
        assert {name, *others} <= units.keys(), row
