"""Results of a check: the stored part, and its transfer over the link."""

import random

import pytest

from pathgene.hdl.feasibility.layouts import count_layout, verdict_layout
from pathgene.hdl.feasibility.result_store import RecordLayouts, ResultStore
from pathgene.hdl.protocol.paths import PathResult, pack_results
from tests.support.gateware.chips import TINY
from tests.support.gateware.streams import collect, pulse, put, simulate


CONFIG = TINY.replace(max_waypoints=6, map_size=32, altitude_bits=12, checker="parallel")
PAUSES = pytest.mark.parametrize("pauses", [(0,), (0, 2, 1)], ids=["steady", "stalled"])


def random_result(rng, counting):
    """A result and the rest of its verdict."""
    segments = CONFIG.max_segments
    fields = {"cells": rng.randrange(200), "reads": rng.randrange(400), "cycles": rng.randrange(99)}
    if rng.random() < 0.4:
        return PathResult(), fields
    entries = ()
    if counting:
        hit = sorted(rng.sample(range(segments), rng.choice((1, 2, segments))))
        entries = tuple((segment, rng.randrange(33), rng.randrange(33)) for segment in hit)
    result = PathResult(
        collision=True,
        segment=rng.randrange(segments),
        cell=(rng.randrange(32), rng.randrange(32)),
        coarse=bool(rng.getrandbits(1)),
        cells=fields["cells"],
        entries=entries,
    )
    return result, fields


def verdict_of(result, fields):
    x, y = result.cell or (0, 0)
    return fields | {
        "collision": result.collision,
        "segment": result.segment or 0,
        "x": x,
        "y": y,
        "coarse": result.coarse or 0,
        "entries": len(result.entries),
    }


def served(batches, reads, *, pauses=(0,), late=False):
    """Return the bytes of ``reads`` after each of ``batches``, and the totals and their cycles.

    ``late``: entries arrive after all verdicts, instead of each before its own verdict.
    """
    store = ResultStore(
        CONFIG.checked_paths,
        CONFIG.max_segments,
        verdict_layout(CONFIG.coordinate_bits, CONFIG.segment_bits, CONFIG.path_cells_bits),
        count_layout(CONFIG.coordinate_bits, CONFIG.segment_bits),
        RecordLayouts.of(CONFIG),
    )
    records, outcomes = [], []

    async def bench(ctx):
        for batch in batches:
            await pulse(ctx, store.clear)
            await ctx.tick()
            assert (ctx.get(store.paths), ctx.get(store.complete)) == (0, 1)
            told = [entry for result, _ in batch for entry in result.entries]
            if late:
                for result, fields in batch:
                    await put(ctx, store.verdicts, verdict_of(result, fields), limit=1)
            come = 0
            for result, fields in batch:
                for segment, terrain, nofly in result.entries:
                    if late:
                        assert not ctx.get(store.complete)
                    entry = {"segment": segment, "terrain": terrain, "nofly": nofly}
                    await put(ctx, store.counts, entry, limit=1)
                    come += 1
                if not late:
                    await put(ctx, store.verdicts, verdict_of(result, fields), limit=1)
            await ctx.tick()
            assert come == len(told)
            assert (ctx.get(store.paths), ctx.get(store.complete)) == (len(batch), 1)
            totals = ctx.get(store.totals)
            bodies = []
            for path, count in reads:
                records.clear()
                await put(ctx, store.reads, {"path": path, "count": count}, limit=1)
                cycles = 0
                while not (records and records[-1].last):
                    await ctx.tick()
                    cycles += 1
                await ctx.tick()
                assert [record.last for record in records[:-1]] == [0] * (len(records) - 1)
                bodies.append((bytes(record.data for record in records), cycles))
            outcomes.append((bodies, totals))

    simulate(store, bench, background=(collect(store.records, records, pauses),))
    return outcomes


READS = [(0, 8), (3, 1), (7, 1), (0, 1), (2, 5)]


@PAUSES
@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("counting", [False, True])
def test_what_is_kept_is_served(counting, late, pauses):
    rng = random.Random(counting)
    batches = [[random_result(rng, counting) for _ in range(8)] for _ in range(3)]
    outcomes = served(batches, READS, pauses=pauses, late=late)
    for batch, (bodies, totals) in zip(batches, outcomes, strict=True):
        for (path, count), (body, _) in zip(READS, bodies, strict=True):
            results = [result for result, _ in batch[path : path + count]]
            assert body == pack_results(CONFIG, results)
        for name in ("cycles", "reads", "cells"):
            assert totals[name] == sum(fields[name] for _, fields in batch)


def test_the_most_there_can_be():
    """Every segment of every path has an entry."""
    most = CONFIG.map_size
    entries = tuple((segment, most, most) for segment in range(CONFIG.max_segments))
    result = PathResult(True, CONFIG.max_segments - 1, (31, 31), True, 224, entries)
    fields = {"cells": 224, "reads": 511, "cycles": (1 << 24) - 1}
    [([(body, _)], totals)] = served([[(result, fields)] * 8], [(0, 8)])
    assert body == pack_results(CONFIG, [result] * 8)
    assert totals.cycles == 8 * ((1 << 24) - 1)


def test_cycles():
    """The first byte takes 3 cycles, each byte one, and each path and each entry 2 more."""
    free = PathResult(), {"cells": 0, "reads": 0, "cycles": 0}
    entries = ((0, 1, 2), (3, 4, 5))
    hit = PathResult(True, 1, (2, 3), False, 4, entries), free[1]
    for batch in ([free], [free] * 4, [hit], [hit, free, hit]):
        [([(body, cycles)], _)] = served([batch], [(0, len(batch))])
        entries = sum(len(result.entries) for result, _ in batch)
        # The bench notices it one cycle late.
        assert cycles - 1 == len(body) + 2 * (len(batch) + entries)
