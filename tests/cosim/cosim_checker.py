"""The exported parallel checker on a map of 64 x 64: queues, stalls, a reset."""

import cocotb
from checker_bench import check_alone, check_queues, check_reset

from hdl.config import CheckerBuild, Config


TOP = "path_checker"
CONFIG = Config(
    max_waypoints=6,
    map_size=64,
    coarse_factor=4,
    altitude_bits=6,
    checker=CheckerBuild.PARALLEL,
    lanes=4,
)


@cocotb.test()
@cocotb.parametrize(stalled=[False, True], count=[False, True])
async def queues(dut, stalled, count):
    await check_queues(dut, CONFIG, stalled=stalled, count=count)


@cocotb.test()
async def alone(dut):
    await check_alone(dut, CONFIG)


@cocotb.test()
async def reset_during_a_check(dut):
    await check_reset(dut, CONFIG)
