"""The exported core of a chip with a map in its default sizes, compared with the model."""

import cocotb
from core_bench import Bench

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.protocol import Counter


TOP = "ga_core"
CONFIG = Config(checker=CheckerBuild.PARALLEL)


@cocotb.test()
async def random_generations(dut):
    """Breed over maps with frequent hits, with and without avoiding the ground."""
    bench = Bench(dut, CONFIG, seed=5, stalled=True)
    await bench.reset()
    left_out = redrawn = waited = 0
    for run in range(6):
        bench.survey(0, bench.rng.choice((1000, 3000, 4095)))
        await bench.start(bench.rng.getrandbits(64), avoid_ground=run % 3 > 0)
        # Short paths have passed before all candidates are looked up.
        await bench.load_all(CONFIG.MIN_WAYPOINTS if run % 2 else None)
        for _ in range(5):
            done = await bench.generate()
            left_out += done.left_out
            redrawn += done.redrawn
            waited += done.mutation_cycles > 2
        await bench.check_population()
    counters = bench.value("counters")
    assert (counters[Counter.LEFT_OUT], counters[Counter.REDRAWN]) == (left_out, redrawn)
    assert left_out > 10
    assert redrawn > 20
    assert waited > 5


@cocotb.test()
async def full_length_parents(dut):
    """Breed in the same cycles as without a map, however many waypoints the ground rejects."""
    bench = Bench(dut, CONFIG, seed=6)
    await bench.reset()
    for lowest in (4095, 0):
        bench.survey(lowest, 4095)
        await bench.start(bench.rng.getrandbits(64), avoid_ground=True)
        await bench.load_all(CONFIG.max_waypoints)
        refused = left_out = 0
        for _ in range(8):
            done = await bench.generate()
            refused += done.refused
            left_out += done.left_out
            longest = bench.value("counters")[Counter.LONGEST]
            assert longest == CONFIG.max_waypoints + 4 <= CONFIG.max_waypoints + 8
        await bench.check_population()
        assert refused > 0
        assert left_out > 0
