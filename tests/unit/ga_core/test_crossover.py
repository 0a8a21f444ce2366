"""The crossover module compared with the model, for every pair of lengths."""

import itertools

import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.ga_core.crossover import Crossover, parents_of
from pathgene.hdl.protocol.breeding import crossover
from tests.support.gateware.streams import shared, simulate


def breed(config, pairs):
    """Return the children of each pair of parents, as heads and tails."""
    dut = shared(Crossover, config.waypoint_bits, config.max_waypoints)
    bred = []

    async def testbench(ctx):
        for parents in pairs:
            children = [({}, {}), ({}, {})]
            for position in range(config.max_waypoints):
                ctx.set(dut.on, 1)
                ctx.set(dut.position, position)
                for port, path in zip(dut.parents, parents, strict=True):
                    ctx.set(port.length, len(path))
                    # Past the end of a path, any waypoint is accepted.
                    ctx.set(port.waypoint, path[position] if position < len(path) else 999)
                for child, halves in enumerate(zip(dut.heads, dut.tails, strict=True)):
                    for half, written in zip(halves, children[child], strict=True):
                        if ctx.get(half.valid):
                            assert ctx.get(half.at) not in written
                            written[ctx.get(half.at)] = ctx.get(half.waypoint)
                await ctx.delay(1e-8)
            bred.append(children)
            ctx.set(dut.on, 0)
            assert not any(ctx.get(half.valid) for half in (*dut.heads, *dut.tails))

    simulate(dut, testbench)
    return bred


@pytest.mark.parametrize("max_waypoints", [3, 5, 8])
def test_every_pair_of_lengths(max_waypoints):
    config = Config(max_waypoints=max_waypoints)
    lengths = range(config.MIN_WAYPOINTS, max_waypoints + 1)
    pairs = [
        ([100 + i for i in range(first)], [200 + i for i in range(second)])
        for first, second in itertools.product(lengths, lengths)
    ]
    for parents, children in zip(pairs, breed(config, pairs), strict=True):
        joined = []
        for head, tail in children:
            # They have no gaps, start at 0 and stay within the halves of a chromosome.
            assert list(head) == list(range(len(head)))
            assert list(tail) == list(range(len(tail)))
            assert len(head) <= config.head_size
            assert len(tail) <= config.max_waypoints - config.head_size
            joined.append([*head.values(), *tail.values()])
        assert joined == crossover(parents)[:2]


def test_parents_are_a_ring_and_used_twice():
    config = Config()
    paths = [[2 * i, 2 * i + 1] for i in range(config.crossovers)]
    for child, path in enumerate(crossover(paths)):
        head, tail = parents_of(child, config.crossovers)
        assert path == [paths[head][0], paths[tail][1]]
