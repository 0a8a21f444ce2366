"""Small units of the core: nearest corners, and the status of a run."""

import random

import numpy as np
import pytest

from pathgene.hdl.planner.core import NearestCorner, RunStatus
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass
from pathgene.sim.model.planner.definition.score import corner_of
from tests.support.gateware.streams import shared, simulate
from tests.support.planner.cases import LARGE, SMALL, any_record
from tests.support.planner.population import corner


@pytest.mark.parametrize("config", [SMALL, LARGE], ids=["small", "large"])
def test_matches_the_definition(config):
    rng = np.random.default_rng(1)
    dut = shared(NearestCorner, config.coordinate_bits, config.altitude_bits)
    clamped = 0

    async def bench(ctx):
        nonlocal clamped
        for _ in range(300):
            record = any_record(config, rng)
            for end in ("start", "goal"):
                position = {
                    name: getattr(record, f"{end}_{name}") for name in ("x", "y", "altitude")
                }
                ctx.set(dut.position, position)
                ctx.set(dut.limits, corner((record.x_limit, record.y_limit, 0)))
                await ctx.tick()
                found = ctx.get(dut.corner)
                assert (found.x, found.y, found.altitude) == corner_of(record, end)
                clamped += found.x == record.x_limit

    simulate(dut, bench)
    assert 0 < clamped < 600


VOID = PathClass.VOID << VALUE_BITS
COUNTED = {"breed": "planning", "sort": "sorting", "wavefront": "spreading"}
PASSED = {"generation": "generations", "cycles": "cycles", "score": "score", "walk": "walk"}


def test_counters_and_key():
    dut, rng = RunStatus(), random.Random(5)
    seen = set()

    async def bench(ctx):
        expected = dict.fromkeys(COUNTED, 0)
        key, bred, ends = VOID, [0, 0, 0], False
        before = {"launch": 0, "running": 0, **dict.fromkeys(COUNTED.values(), 0)}
        for cycle in range(3000):
            values = {name: rng.getrandbits(32) for name in PASSED.values()}
            values |= {name: rng.randrange(2) for name in COUNTED.values()}
            values |= {"launch": rng.random() < 0.01, "running": cycle % 500 < 400}
            values |= {"bred": rng.random() < 0.1, "best": rng.getrandbits(30)}
            values |= {"first": rng.getrandbits(30), "is_first": rng.random() < 0.1}
            values["void"] = rng.random() < 0.02
            for name, value in values.items():
                ctx.set(getattr(dut, name), value)
            status = ctx.get(dut.status)
            assert {name: status[name] for name in COUNTED} == expected
            assert {name: status[name] for name in PASSED} == {
                name: values[source] for name, source in PASSED.items()
            }
            assert status.running == before["running"]
            assert status.key == key
            for name, source in COUNTED.items():
                expected[name] += before[source] & before["running"]
                if before["launch"]:
                    expected[name] = 0
            before = values
            # The best of a generation, 3 cycles after its start.
            if bred[-3]:
                key = values["best"]
            if values["is_first"]:
                key = values["first"]
            if ends:
                key = VOID
            ends = values["launch"] or values["void"]
            seen.add(key == VOID)
            bred.append(values["bred"])
            await ctx.tick()

    simulate(dut, bench)
    assert seen == {False, True}
