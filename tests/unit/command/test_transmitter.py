"""Reply transmitter: the body of every answer, byte by byte."""

import random
import zlib

import pytest

from pathgene.hdl.command.layouts import AnswerKind
from pathgene.hdl.command.transmitter import ReplyTransmitter
from pathgene.hdl.config import CheckerBuild
from pathgene.hdl.protocol.codes import Status
from pathgene.hdl.protocol.messages import (
    check_reply,
    counters_reply,
    info_reply,
    info_values,
    recipe_reply,
    status_reply,
    survivors_reply,
)
from pathgene.hdl.protocol.paths import pack_paths
from tests.support.gateware.chips import TINY
from tests.support.gateware.streams import collect, put, shared, simulate


CONFIG = TINY.replace(altitude_bits=12, checker="parallel")
HEADER = bytes((3, 200, Status.OK))


def random_fields(layout, rng):
    return {name: rng.getrandbits(width) for name, width in layout.fields}


async def ask(ctx, unit, replies, bodies, times=2, **answer):
    """Have an answer sent some times; move its bytes from ``replies`` to ``bodies``."""
    header = dict(zip(("session", "sequence", "status"), HEADER, strict=True))
    answer = {**header, "plain": 0, "slot": 0, "count": 0, **answer}
    ctx.set(unit.answer, answer)
    for _ in range(times):
        ctx.set(unit.on, 1)
        for _ in range(5000):
            await ctx.tick()
            if ctx.get(unit.done):
                break
        assert ctx.get(unit.done)
        ctx.set(unit.on, 0)
        await ctx.tick().repeat(10)
        assert [byte.last for byte in replies] == ([0] * (len(replies) - 1) + [1])[: len(replies)]
        assert {byte.plain for byte in replies} <= {answer["plain"]}
        bodies.append(bytes(byte.data for byte in replies))
        replies.clear()


def answers(kind, *, slot=0, count=0, plain=0, pauses=(0,), seed=1, times=1):
    """Return the bodies sent for ``kind``, the registers after them, and the paths read."""
    rng = random.Random(seed)
    unit = shared(ReplyTransmitter, CONFIG)
    paths = [
        [rng.getrandbits(CONFIG.waypoint_bits) for _ in range(rng.randint(2, 4))] for _ in range(8)
    ]
    registers = {
        "status": random_fields(status_reply(CONFIG), rng),
        "counters": random_fields(counters_reply(CONFIG), rng),
        "recipe": random_fields(recipe_reply(CONFIG), rng) | {"checksum": 0},
        "survivors": [rng.randrange(8) for _ in range(2)],
    }
    replies, bodies, reads = [], [], []

    async def registers_and_hand_over(ctx):
        recipe = dict(registers["recipe"])
        del recipe["checksum"]
        ctx.set(unit.status, registers["status"])
        ctx.set(unit.counters, registers["counters"])
        ctx.set(unit.recipe, recipe)
        ctx.set(unit.survivors, registers["survivors"])
        ctx.set(unit.session, 77)
        answer = {"kind": kind, "plain": plain, "slot": slot, "count": count}
        await ask(ctx, unit, replies, bodies, times, **answer)

    async def read_out(ctx):
        while True:
            ctx.set(unit.reads.ready, 1)
            _, _, valid, read = await ctx.tick().sample(unit.reads.valid, unit.reads.payload)
            ctx.set(unit.reads.ready, 0)
            if not valid:
                continue
            reads.append((read.slot, read.count))
            asked = range(read.slot, read.slot + read.count)
            for number in asked:
                for index, waypoint in enumerate(paths[number]):
                    last = index == len(paths[number]) - 1
                    final = last and number == asked[-1]
                    word = {"waypoint": waypoint, "last": last, "final": final}
                    for _ in range(rng.randrange(3)):
                        await ctx.tick()
                    await put(ctx, unit.waypoints, word)

    simulate(
        unit, registers_and_hand_over, background=(read_out, collect(unit.replies, replies, pauses))
    )
    return bodies, registers, paths, reads


PAUSES = pytest.mark.parametrize("pauses", [(0,), (0, 2, 1)], ids=["steady", "stalled"])


@PAUSES
def test_fixed_fields(pauses):
    (body,), registers, _, _ = answers(AnswerKind.STATUS, pauses=pauses)
    assert body == HEADER + status_reply(CONFIG).pack(**registers["status"])
    (body,), registers, _, _ = answers(AnswerKind.COUNTERS, pauses=pauses)
    assert body == HEADER + counters_reply(CONFIG).pack(**registers["counters"])


def test_information_is_plain_and_names_the_session():
    (body,), _, _, _ = answers(AnswerKind.INFO, plain=1)
    assert body == HEADER + info_reply(CONFIG).pack(session=77, **info_values(CONFIG))


def test_nothing_but_the_header():
    bodies, _, _, _ = answers(AnswerKind.EMPTY, times=3)
    assert bodies == [HEADER] * 3


def test_silence():
    bodies, _, _, reads = answers(AnswerKind.SILENCE, times=2)
    assert (bodies, reads) == ([b"", b""], [])


@PAUSES
def test_paths(pauses):
    (body,), _, paths, reads = answers(AnswerKind.PATHS, slot=2, count=5, pauses=pauses)
    assert body == HEADER + pack_paths(CONFIG, paths[2:7])
    assert reads == [(2, 5)]


@PAUSES
def test_children(pauses):
    (body,), registers, paths, reads = answers(AnswerKind.CHILDREN, slot=4, count=4, pauses=pauses)
    named = {f"survivor_{i}": slot for i, slot in enumerate(registers["survivors"])}
    expected = HEADER + survivors_reply(CONFIG).pack(**named) + pack_paths(CONFIG, paths[4:])
    assert body == expected
    assert reads == [(4, 4)]


@PAUSES
def test_recipe_sums_up_the_whole_population(pauses):
    bodies, registers, paths, reads = answers(
        AnswerKind.RECIPE, slot=5, count=1, pauses=pauses, times=2
    )
    checksum = zlib.crc32(pack_paths(CONFIG, paths))
    expected = HEADER + recipe_reply(CONFIG).pack(**registers["recipe"] | {"checksum": checksum})
    assert bodies == [expected] * 2
    assert reads == [(0, 8)] * 2


def checked_answers(kind, *, checked, slot=0, count=0, pauses=(0,)):
    """Return two bodies sent for ``kind``, the totals, and the requests for results."""
    rng = random.Random(3)
    unit = shared(ReplyTransmitter, CONFIG.replace(checker=CheckerBuild.PARALLEL))
    totals = random_fields(check_reply(CONFIG), rng)
    replies, bodies, reads = [], [], []

    async def bench(ctx):
        ctx.set(unit.totals, totals)
        ctx.set(unit.checked, checked)
        await ask(ctx, unit, replies, bodies, kind=kind, slot=slot, count=count)

    async def serve(ctx):
        """Serve results of two bytes: the number of the path and 0xEE."""
        while True:
            ctx.set(unit.result_reads.ready, 1)
            _, _, valid, read = await ctx.tick().sample(
                unit.result_reads.valid, unit.result_reads.payload
            )
            ctx.set(unit.result_reads.ready, 0)
            if not valid:
                continue
            reads.append((read.path, read.count))
            data = [byte for path in range(read.count) for byte in (read.path + path, 0xEE)]
            for at, byte in enumerate(data):
                for _ in range(rng.randrange(3)):
                    await ctx.tick()
                await put(ctx, unit.records, {"data": byte, "last": at == len(data) - 1})

    simulate(unit, bench, background=(serve, collect(unit.replies, replies, pauses)))
    assert bodies[0] == bodies[1]
    return bodies[0], check_reply(CONFIG).pack(**totals), reads


@PAUSES
@pytest.mark.parametrize("checked", [1, 8])
def test_checked_paths(checked, pauses):
    body, totals, reads = checked_answers(AnswerKind.CHECKED, checked=checked, pauses=pauses)
    assert body == HEADER + totals + bytes(byte for path in range(checked) for byte in (path, 0xEE))
    assert reads == [(0, checked)] * 2


def test_totals_alone():
    """Totals are sent alone if requested, or if no path has been checked."""
    body, totals, reads = checked_answers(AnswerKind.TOTALS, checked=8)
    assert (body, reads) == (HEADER + totals, [])
    body, totals, reads = checked_answers(AnswerKind.CHECKED, checked=0)
    assert (body, reads) == (HEADER + totals, [])


@PAUSES
def test_results_alone(pauses):
    body, _, reads = checked_answers(AnswerKind.RESULTS, checked=8, slot=5, count=3, pauses=pauses)
    assert body == HEADER + bytes((5, 0xEE, 6, 0xEE, 7, 0xEE))
    assert reads == [(5, 3)] * 2


PLANNER = CONFIG.replace(core="planner", checker=CheckerBuild.PARALLEL)


def run_answers(kind, *, records=b"", pauses=(0,), ticking=False):
    """Return two bodies that a planner chip sends for ``kind``, its registers, and the pulses.

    With ``ticking``, the cycles of the run continue.
    """
    rng = random.Random(4)
    unit = shared(ReplyTransmitter, PLANNER)
    status = random_fields(status_reply(PLANNER), rng)
    if ticking:
        status["cycles"] = 0xFFF8
    replies, bodies, pulses = [], [], []

    async def bench(ctx):
        ctx.set(unit.status, status)
        ctx.set(unit.has_best, len(records) > 0)
        await ask(ctx, unit, replies, bodies, kind=kind)

    async def serve(ctx):
        while True:
            _, _, asked = await ctx.tick().sample(unit.best)
            if not asked:
                continue
            pulses.append(len(bodies))
            for _ in range(9):
                _, _, again = await ctx.tick().sample(unit.best)
                assert not again
            for at, byte in enumerate(records):
                await ctx.tick().repeat(rng.randrange(1, 3))
                await put(ctx, unit.records, {"data": byte, "last": at == len(records) - 1})

    async def tick_on(ctx):
        while ticking:
            await ctx.tick()
            ctx.set(unit.status.cycles, ctx.get(unit.status.cycles) + 1)

    simulate(unit, bench, background=(serve, collect(unit.replies, replies, pauses), tick_on))
    return bodies, status, pulses


@PAUSES
def test_best_paths(pauses):
    records = bytes(range(40, 60))
    bodies, _, pulses = run_answers(AnswerKind.BEST, records=records, pauses=pauses)
    assert bodies == [HEADER + records] * 2
    assert pulses == [0, 1]


def test_without_paths_the_header_alone():
    assert run_answers(AnswerKind.BEST)[::2] == ([HEADER] * 2, [])


@PAUSES
def test_status_of_a_run(pauses):
    bodies, status, pulses = run_answers(AnswerKind.STATUS, pauses=pauses)
    assert bodies == [HEADER + status_reply(PLANNER).pack(**status)] * 2
    assert pulses == []


def test_every_field_of_a_status_is_read_in_one_cycle():
    """A running counter is read as a value that it had, even when its lower half overflows."""
    bodies, status, _ = run_answers(AnswerKind.STATUS, pauses=(3,), ticking=True)
    first, second = (status_reply(PLANNER).unpack(body[len(HEADER) :]) for body in bodies)
    assert 0xFFF8 < first.pop("cycles") < 0x10_100
    assert 0x10_000 < second.pop("cycles") < 0x10_300
    del status["cycles"]
    assert first == second == status
