"""The exported planner: a cold run, and a run that continues from it and is stopped.

The flight, compared with the model, is the same as in ``test_planner_core.py``.
"""

import cocotb
from cocotb.clock import Clock
from cocotb.task import bridge, resume
from cocotb.triggers import ClockCycles, FallingEdge, RisingEdge

from pathgene.hdl.protocol.planner import MEMO_ROWS
from pathgene.hdl.protocol.runs import RunOptions
from tests.support.planner.cases import SMALL
from tests.support.planner.flight import (
    Flight,
    problem_payload,
    run_payload,
    shape_payload,
    status_fields,
)


TOP = "planner_core"
CONFIG = SMALL


class SimulatedPlanner:
    """The planner, for the model's flight in a thread; ports are driven at falling edges."""

    def __init__(self, dut):
        self._dut = dut
        for name in ("write", "pose", "draw", "run", "status", "best"):
            setattr(self, name, resume(getattr(self, f"_{name}")))

    async def power_up(self):
        dut = self._dut
        for name in ("cells", "shapes", "problems", "runs"):
            getattr(dut, f"{name}__valid").value = 0
            getattr(dut, f"{name}__payload").value = 0
        dut.stop.value = dut.best.value = dut.records__ready.value = 0
        dut.rst.value = 1
        Clock(dut.clk, 10, unit="ns").start()
        await ClockCycles(dut.clk, 4, FallingEdge)
        dut.rst.value = 0

    async def _offer(self, name, bits):
        """Offer a payload until it is taken; return the cycles until then."""
        valid, ready = getattr(self._dut, f"{name}__valid"), getattr(self._dut, f"{name}__ready")
        getattr(self._dut, f"{name}__payload").value = bits
        valid.value = 1
        cycles, is_taken = 0, False
        while not is_taken:
            await RisingEdge(self._dut.clk)
            is_taken = bool(ready.value)
            await FallingEdge(self._dut.clk)
            cycles += not is_taken
        valid.value = 0
        return cycles

    async def _write(self, ground, x, y):
        bits = CONFIG.coordinate_bits
        for column, row in zip(x.tolist(), y.tolist(), strict=True):
            altitude = int(ground[row, column])
            await self._offer("cells", column | row << bits | altitude << 2 * bits)

    async def _pose(self, record):
        await self._offer("problems", problem_payload(CONFIG, record).as_bits())

    async def _draw(self, shape):
        return await self._offer("shapes", shape_payload(CONFIG, shape).as_bits())

    async def _run(self, options, *, gap=0, stop=0):
        dut = self._dut
        if gap:
            await ClockCycles(dut.clk, gap, FallingEdge)
        await self._offer("runs", run_payload(CONFIG, options).as_bits())
        cycles = bred = 0
        while dut.running.value:
            dut.stop.value = stop != 0 and cycles == stop
            await RisingEdge(dut.clk)
            bred += int(dut.bred.value)
            await FallingEdge(dut.clk)
            cycles += 1
        dut.stop.value = 0
        return cycles, bred

    async def _status(self):
        dut = self._dut
        await ClockCycles(dut.clk, 4, FallingEdge)
        flags = [int(flag.value) for flag in (dut.has_problem, dut.has_population, dut.has_best)]
        return flags, status_fields(dut.status.value.to_unsigned())

    async def _best(self, stall=0):
        """Read the best paths; a record moves in one of ``stall`` cycles."""
        dut = self._dut
        dut.best.value = 1
        await FallingEdge(dut.clk)
        dut.best.value = 0
        received, is_last = bytearray(), False
        while not is_last:
            if stall:
                await ClockCycles(dut.clk, stall, FallingEdge)
            dut.records__ready.value = 1
            await RisingEdge(dut.clk)
            if dut.records__valid.value:
                record = dut.records__payload.value.to_unsigned()
                received.append(record & 0xFF)
                is_last = bool(record >> 8)
            await FallingEdge(dut.clk)
            dut.records__ready.value = 0
        return bytes(received)


@cocotb.test()
async def runs(dut):
    """Go through a first population, generations, a shape, and a warm start that is stopped.

    The wavefront alone takes 13,000 cycles, so there is one island; ``test_planner_core.py`` has
    everything else on Verilator.
    """
    chip = SimulatedPlanner(dut)
    await chip.power_up()

    def fly():
        flight = Flight(CONFIG, MEMO_ROWS, 4, chip)
        assert chip.status()[0] == [0, 0, 0]
        flight.upload()
        flight.pose()
        few = {"seeds": 8, "cycles": 10**9, "give_up_rank": 3, "paths": 4}
        flight.run(RunOptions(seed=5, generations=6, lifts=0, slopes=(0,), **few))
        before = flight.ground.copy()
        while (flight.ground == before).all():
            flight.change()
        flight.run(RunOptions(seed=7, generations=900, slopes=(), warm=True, **few), stop=4000)
        assert 2 < flight.outcome.generations < 900

    await bridge(fly)()
