"""The exported core in its default configuration, compared with the model."""

import cocotb
from cocotb.triggers import RisingEdge
from core_bench import Bench

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.protocol import Counter


TOP = "ga_core"
CONFIG = Config(checker=CheckerBuild.NONE)


@cocotb.test()
@cocotb.parametrize(stalled=[False, True])
async def random_generations(dut, stalled):
    """Breed random paths, with loads, reads and new seeds between the generations."""
    bench = Bench(dut, CONFIG, seed=1, stalled=stalled)
    await bench.reset()
    if not stalled:
        # A reset does not clear the memories, so this checks their contents at power-up.
        await bench.check_population()
    await bench.load_all()
    await bench.check_population()
    for generation in range(20):
        if generation % 7 == 3:
            await bench.start(bench.rng.getrandbits(64))
        await bench.generate()
        if generation % 5 == 4:
            await bench.check_population()
        slot = bench.rng.randrange(CONFIG.population)
        await bench.check_paths(slot, min(2, CONFIG.population - slot))
        await bench.load(bench.rng.randrange(CONFIG.population))
    await bench.check_population()


@cocotb.test()
async def full_length_parents(dut):
    """Breed in at most ``max_waypoints + 8`` cycles; measured: ``max_waypoints + 4``."""
    bench = Bench(dut, CONFIG, seed=2)
    await bench.reset()
    refused = 0
    for _ in range(3):
        await bench.load_all(CONFIG.max_waypoints)
        for _ in range(10):
            done = await bench.generate()
            refused += sum(not mutated.applied for mutated in done.mutations)
            longest = bench.value("counters")[Counter.LONGEST]
            assert longest == CONFIG.max_waypoints + 4 <= CONFIG.max_waypoints + 8
        await bench.check_population()
    counters = bench.value("counters")
    assert refused > 0
    assert counters[Counter.REFUSED_MUTATIONS] == refused
    assert counters[Counter.GENERATIONS] == 30


@cocotb.test()
async def generation_waits_for_its_draws(dut):
    """Start a generation requested right after a new seed when its draws are ready."""
    bench = Bench(dut, CONFIG, seed=3)
    await bench.reset()
    await bench.load_all()
    for _ in range(4):
        await bench.start(bench.rng.getrandbits(64))
        await bench.generate()
        await bench.generate()
    await bench.check_population()


@cocotb.test()
async def ranked_after_the_last_rank(dut):
    """Raise ``ranked`` as many cycles after the last rank as the docstring of the core states."""
    bench = Bench(dut, CONFIG, seed=4)
    await bench.reset()
    await bench.streams["ranking"].put(
        *({"rank": rank, "slot": rank} for rank in range(CONFIG.population))
    )
    begun = cocotb.simtime.get_sim_time("ns")
    await RisingEdge(dut.ranked)
    elapsed = cocotb.simtime.get_sim_time("ns") - begun
    # From the falling edge after the last rank's transfer to a rising edge.
    assert elapsed == 10 * (CONFIG.mutators + 13) - 15
