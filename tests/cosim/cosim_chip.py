"""The whole exported chip at its UART pins, driven by the host, compared with the model.

CHIP in the environment selects the configuration: ``small``, with a collision checker, or
``default`` for the paper's sizes.
"""

import itertools
import os
import random

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.simtime import get_sim_time
from cocotb.task import bridge, resume
from cocotb.triggers import Event, FallingEdge, First, Timer

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import encode_frame
from pathgene.hdl.protocol.codes import Command, LinkMode, StickyError
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link, LinkError
from pathgene.sim.model.chip import Chip as ChipModel
from pathgene.sim.model.chip import ModelPort
from tests.support.gateware.chips import CHECKING, Pair, random_path, without_line_cycles


TOP = "chip"
CONFIG = {"small": CHECKING, "default": Config(clocks_per_bit=4)}[os.environ.get("CHIP", "small")]

CLOCK_NS = 10
BIT_NS = CLOCK_NS * CONFIG.clocks_per_bit
BYTE_NS = 10 * BIT_NS
#: Longer than the chip's longest silence; an attempt, 8 times as long, must fit a window of frames.
TIMEOUT_S = CONFIG.receive_buffer * BYTE_NS / 4 * 1e-9


class Pins:
    """A serial port at the pins of the chip, for host code in a thread.

    Time is simulated: a call returns when the simulation has done its work.

    Parameters
    ----------
    dut : cocotb handle
        The chip. :meth:`power_up` starts its clock and resets it.
    """

    def __init__(self, dut):
        self.timeout = None
        self.closed = False
        #: Function that the line applies to each write.
        self.fault = bytes
        #: Cycles after the next write at which the chip is reset for one cycle.
        self.reset_after = None
        self._dut = dut
        self._received = bytearray()
        self._arrived = Event()
        self._now_ns = 0
        self.read = resume(self._read)
        self.write = resume(self._write)
        self.hold_low = resume(self._hold_low)
        self.reset = resume(self._reset)

    async def power_up(self):
        self._dut.rx.value = 1
        Clock(self._dut.clk, CLOCK_NS, unit="ns").start()
        await self._reset()
        cocotb.start_soon(self._collect())

    @property
    def in_waiting(self):
        return len(self._received)

    def now_s(self):
        """Return the simulated seconds at the end of the latest call."""
        return self._now_ns * 1e-9

    def close(self):
        self.closed = True

    async def _reset(self, cycles=3, after=0):
        if after:
            await Timer(after * CLOCK_NS, "ns")
        self._dut.rst.value = 1
        await Timer(cycles * CLOCK_NS, "ns")
        self._dut.rst.value = 0
        await Timer(CLOCK_NS, "ns")

    async def _collect(self):
        """Collect the bytes on ``tx``."""
        tx = self._dut.tx
        while True:
            if tx.value:
                await FallingEdge(tx)
            await Timer(BIT_NS // 2, "ns")
            value = 0
            for bit in range(8):
                await Timer(BIT_NS, "ns")
                value |= int(tx.value) << bit
            await Timer(BIT_NS, "ns")
            assert tx.value == 1, "a byte without a stop bit"
            self._received.append(value)
            self._arrived.set()

    async def _read(self, size):
        deadline = get_sim_time("ns") + self.timeout * 1e9
        while len(self._received) < size:
            left = round(deadline - get_sim_time("ns"))
            if left <= 0:
                break
            self._arrived.clear()
            await First(self._arrived.wait(), Timer(left, "ns"))
        self._now_ns = get_sim_time("ns")
        part = bytes(self._received[:size])
        del self._received[:size]
        return part

    async def _write(self, data):
        for value in self.fault(bytes(data)):
            bits = (0, *(value >> bit & 1 for bit in range(8)), 1)
            for level, run in itertools.groupby(bits):
                self._dut.rx.value = level
                await Timer(BIT_NS * len(list(run)), "ns")
        if self.reset_after is not None:
            cocotb.start_soon(self._reset(cycles=1, after=self.reset_after))
            self.reset_after = None
        self._now_ns = get_sim_time("ns")
        return len(data)

    async def _hold_low(self, bits):
        self._dut.rx.value = 0
        await Timer(bits * BIT_NS, "ns")
        self._dut.rx.value = 1
        await Timer(2 * BIT_NS, "ns")


def with_host(test):
    """Make a cocotb test of ``test``, a function of pins and a pair of chips run in a thread."""

    async def run(dut):
        pins = Pins(dut)
        await pins.power_up()

        def host():
            board = Chip(Link(pins, timeout_s=TIMEOUT_S, attempts=4, clock=pins.now_s))
            model = Chip(Link(ModelPort(ChipModel(CONFIG)), timeout_s=1, attempts=1))
            test(pins, Pair(board, model))
            board.close()
            assert pins.closed

        await bridge(host)()

    run.__name__ = run.__qualname__ = test.__name__
    run.__doc__ = test.__doc__
    return cocotb.test(run)


@with_host
def every_command(pins, chips):
    """Run the host's commands in all link modes; compare populations, status and counters."""
    assert chips.board.info == chips.model.info
    # A reset does not clear the memories, so this checks their contents at power-up.
    assert chips.board.read(0, CONFIG.population) == [[0, 0]] * CONFIG.population
    assert chips.model.read(0, CONFIG.population) == [[0, 0]] * CONFIG.population
    chips.start()
    for mode in (LinkMode.RECIPE, LinkMode.RANK, LinkMode.POPULATION, LinkMode.RECIPE):
        chips.step(mode)
    counters = chips.check()
    assert counters["generations"] == 4
    assert counters["longest"] <= CONFIG.max_waypoints + 8
    assert counters["clocks"] >= counters["receive"] > 0
    assert counters["clocks"] >= counters["transmit"] > 0


@with_host
def map_and_checks(pins, chips):
    """Run the checker's commands; each is executed once although every frame arrives twice."""
    rng = np.random.default_rng(9)
    edge = CONFIG.map_size
    heights = rng.choice(
        (0, 2, 12, CONFIG.blocked_altitude), (edge, edge), p=(0.7, 0.2, 0.06, 0.04)
    )
    for chip in (chips.board, chips.model):
        chip.upload_map(heights)
    chips.start()
    told = []
    pins.fault = lambda data: data * 2
    for counting in (False, True):
        path = random_path(CONFIG, chips.rng, CONFIG.max_waypoints + 2)
        start, goal = random_path(CONFIG, chips.rng, 2)
        for chip in (chips.board, chips.model):
            told.append(chip.check_path(path, counting=counting))
            told.append(chip.check_population(start, goal, counting=counting))
    pins.fault = bytes
    assert told[0:2] + told[4:6] == told[2:4] + told[6:8]
    assert any(verdict.collision for checked in told for verdict in checked.verdicts)
    counters = chips.board.counters()
    assert counters["paths"] == 2 * (1 + CONFIG.population)
    assert counters["feasibility"] == sum(checked.cycles for checked in told[0:2] + told[4:6])


@with_host
def damaged_frames(pins, chips):
    """Lose, damage and repeat frames on the line; each command is executed once."""
    rng = random.Random(7)
    chips.start()
    traffic = chips.board.link.traffic

    def flip(data):
        at = rng.randrange(1, len(data))
        return data[:at] + bytes((data[at] ^ 1 << rng.randrange(8),)) + data[at + 1 :]

    for number, damage in enumerate((flip, lambda data: b"", lambda data: data[:-3])):
        repeated = traffic.frames_repeated

        def once(data, damage=damage):
            pins.fault = bytes
            return damage(data)

        pins.fault = once
        chips.step(LinkMode.RANK if number == 0 else LinkMode.RECIPE)
        assert traffic.frames_repeated == repeated + 1
    pins.fault = lambda data: data * 2
    chips.step(LinkMode.RECIPE)
    pins.fault = bytes
    assert chips.board.status()["generation"] == 4
    assert chips.board.read(0, CONFIG.population) == chips.paths


@with_host
def garbage_and_break(pins, chips):
    """Reply after arbitrary bytes, and report the line errors."""
    rng = random.Random(8)
    chips.start()
    pins.write(b"\7" * 5 + b"\0")
    pins.write(rng.randbytes(40) + b"\0")
    pins.write(encode_frame(b"\1\2\3\4\5")[:-2] + b"\x55\0")
    pins.write(encode_frame(bytes(CONFIG.receive_buffer + 3)))
    pins.hold_low(25)
    chips.board.link.session = None
    chips.board.link.reopen()
    errors = StickyError(chips.board.status()["errors"])
    assert errors == (
        StickyError.FRAMING | StickyError.OVERRUN | StickyError.CRC | StickyError.MALFORMED
    )
    chips.board.clear_errors()
    assert chips.board.status()["errors"] == 0
    chips.step(LinkMode.RANK)


@with_host
def reset_in_an_answer(pins, chips):
    """Detect a reset during a reply; the chip works afterwards."""
    link = chips.board.link
    pins.write(encode_frame(bytes((0, 0, Command.INFO)), plain=True))
    pins.timeout = TIMEOUT_S
    assert len(pins.read(2)) == 2  # The reply has begun.
    pins.reset()
    # A reset and another host's OPEN look alike, so one message names both.
    with pytest.raises(LinkError, match=r"^The board was reset or taken by another host: open"):
        link.request(Command.STATUS)
    chips.board = Chip(Link(pins, timeout_s=TIMEOUT_S, attempts=4, clock=pins.now_s))
    assert chips.board.info["session"] == 0
    chips.start()
    chips.step(LinkMode.RECIPE)


@with_host
def reset_of_one_cycle(pins, chips):
    """Reset for one cycle during a command; the chip is as after power-up, except its memories."""
    rng = random.Random(10)
    heights = np.random.default_rng(10).integers(0, 12, (CONFIG.map_size, CONFIG.map_size))
    start, goal = random_path(CONFIG, rng, 2)
    commands = [
        lambda board: chips.step(LinkMode.RECIPE),
        lambda board: board.read(0, CONFIG.population),
        lambda board: board.check_population(start, goal),
        lambda board: board.upload_map(heights),
    ]
    # A generation or check begins soon after the command; a reply is long.
    most_cycles = (3, 30, 150, 600)
    if "Icarus" in cocotb.SIM_NAME:
        commands, most_cycles = commands[:1], (30,)
    lost = 0
    for command in commands:
        for after in [rng.randrange(most) for most in most_cycles]:
            pins.reset_after = after
            try:
                command(chips.board)
            except LinkError:
                lost += 1
            pins.reset_after = None
            chips.board = Chip(Link(pins, timeout_s=TIMEOUT_S, attempts=4, clock=pins.now_s))
            chips.model = Chip(Link(ModelPort(ChipModel(CONFIG)), timeout_s=1, attempts=1))
            for chip in (chips.board, chips.model):
                chip.clear_errors()  # The rest of a frame is an error after the reset.
                chip.upload_map(heights)
            chips.start()
            chips.step(LinkMode.RECIPE)
            told = [chip.check_population(start, goal) for chip in (chips.board, chips.model)]
            assert told[0] == told[1]
            paths = [chip.read(0, CONFIG.population) for chip in (chips.board, chips.model)]
            assert paths[0] == paths[1] == chips.paths
            counted = []
            for chip in (chips.board, chips.model):
                counters = without_line_cycles(chip.counters())
                # The host may have repeated a request.
                counted.append({k: v for k, v in counters.items() if not k.startswith("bytes")})
            assert counted[0] == counted[1]
            assert counted[0]["generations"] == 1
    assert lost >= len(commands) * len(most_cycles) / 2
