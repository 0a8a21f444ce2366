"""Keys at the limits of their values, and their cycles."""

import numpy as np

from pathgene.hdl.planner.path_evaluator import KeyMaker
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass
from tests.support.gateware.streams import simulate


TOP = (1 << VALUE_BITS) - 1
#: Walked, infeasible, value, hits: every kind of path, at both ends of the values.
PATHS = [
    (walked, infeasible, value, hits)
    for walked in (0, 1)
    for infeasible in (0, 1)
    for value in (0, 1, TOP - 1024, TOP - 1023, TOP)
    for hits in ((0, 1, 2, (1 << 20) - 1) if walked else (0,))
]


def key_of(walked, infeasible, value, hits):
    """The class and the value of a key."""
    if hits or (walked and infeasible):
        penalty = (value if infeasible else 0) + hits * 4 * 256
        return PathClass.INFEASIBLE << VALUE_BITS | min(penalty, TOP)
    if walked:
        return PathClass.FEASIBLE << VALUE_BITS | value
    return (PathClass.INFEASIBLE if infeasible else PathClass.GIVEN_UP) << VALUE_BITS | value


def run(decided, walked):
    """Return keys, slots and lengths, and their cycles, of paths decided and walked in cycles."""
    dut = KeyMaker(slot_bits=8, length_bits=3, hits_bits=20)
    members, cycles = [], []

    async def bench(ctx):
        ctx.set(dut.evaluated.ready, 1)
        for cycle in range(max(*decided, *walked) + 20):
            number = decided.index(cycle) if cycle in decided else None
            ctx.set(dut.decision.valid, number is not None)
            if number is not None:
                names = ("walked", "infeasible", "value")
                path = {"head": {"slot": number}, "length": number % 8}
                fields = dict(zip(names, PATHS[number], strict=False))
                ctx.set(dut.decision, {"valid": 1, **fields, "path": path})
            number = walked.index(cycle) if cycle in walked else None
            ctx.set(dut.result.valid, number is not None)
            if number is not None:
                ctx.set(dut.result.hits, [path for path in PATHS if path[0]][number][-1])
            if ctx.get(dut.evaluated.valid):
                member = ctx.get(dut.evaluated.p)
                members.append((member.key, member.slot, member.length))
                cycles.append(cycle)
            await ctx.tick()

    simulate(dut, bench)
    return members, cycles


def test_keys():
    """Keys follow decisions, and results, by 3 cycles, or the previous key by one."""
    rng = np.random.default_rng(1)
    for gap in (6, 3, 1):
        decided = np.cumsum(rng.integers(gap, gap + 3, size=len(PATHS))).tolist()
        walked, at, cycles = [], 0, [0]
        for path, cycle in zip(PATHS, decided, strict=True):
            known = cycle
            if path[0]:
                at = max(at, cycle) + int(rng.integers(1, gap + 3))
                walked.append(at)
                known = at
            cycles.append(max(known + 3, cycles[-1] + 1))
        members, found = run(decided, walked)
        expected = [(key_of(*path), i, i % 8) for i, path in enumerate(PATHS)]
        assert members == expected
        assert found == cycles[1:]
