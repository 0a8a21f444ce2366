"""The exported crossover unit against the model: every pair of lengths, full-size waypoints."""

import itertools
import random

import cocotb
from cocotb.triggers import Timer

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.protocol.breeding import crossover


TOP = "crossover"
CONFIG = Config(checker=CheckerBuild.NONE)


async def breed(dut, parents):
    """Stream two parents through the unit; return the two children."""
    written = [({}, {}), ({}, {})]
    dut.on.value = 1
    for position in range(CONFIG.max_waypoints):
        dut.position.value = position
        for number, path in enumerate(parents):
            getattr(dut, f"parents__{number}__length").value = len(path)
            # After the end of a path its port carries arbitrary values.
            waypoint = path[position] if position < len(path) else 0x2AAAAAAA
            getattr(dut, f"parents__{number}__waypoint").value = waypoint
        await Timer(1, "ns")
        for child, halves in enumerate(written):
            for name, half in zip(("heads", "tails"), halves, strict=True):
                port = f"{name}__{child}__"
                if getattr(dut, f"{port}valid").value:
                    at = getattr(dut, f"{port}at").value.to_unsigned()
                    assert at not in half
                    half[at] = getattr(dut, f"{port}waypoint").value.to_unsigned()
    for head, tail in written:
        assert list(head) == list(range(len(head)))
        assert list(tail) == list(range(len(tail)))
        assert len(head) <= CONFIG.head_size
        assert len(tail) <= CONFIG.max_waypoints - CONFIG.head_size
    return [[*head.values(), *tail.values()] for head, tail in written]


@cocotb.test()
async def every_pair_of_lengths(dut):
    """Match the model for every pair of lengths."""
    rng = random.Random(1)
    lengths = range(CONFIG.MIN_WAYPOINTS, CONFIG.max_waypoints + 1)
    for pair in itertools.product(lengths, lengths):
        parents = [[rng.getrandbits(CONFIG.waypoint_bits) for _ in range(n)] for n in pair]
        assert await breed(dut, parents) == crossover(parents)[:2], pair


@cocotb.test()
async def off(dut):
    """Write nothing while the unit is off."""
    dut.on.value = 0
    for position in range(CONFIG.max_waypoints):
        dut.position.value = position
        await Timer(1, "ns")
        for name in ("heads__0", "heads__1", "tails__0", "tails__1"):
            assert not getattr(dut, f"{name}__valid").value
