"""COBS in gateware, compared with the package ``cobs``."""

import itertools
import random

import pytest
from cobs import cobs

from pathgene.hdl.link.cobs import CobsDecoder, CobsEncoder
from tests.support.gateware.streams import drive, shared, simulate, watch


# Every string of up to four of the relevant bytes, then lengths around a full block.
SHORT = [
    bytes(word)
    for length in range(1, 5)
    for word in itertools.product((0, 1, 2, 255), repeat=length)
]
LONG = [
    before + bytes(1 + i % 255 for i in range(length)) + after
    for length in (252, 253, 254, 255, 256, 507, 508, 509)
    for before in (b"", b"\0")
    for after in (b"", b"\0", b"\0\7", b"\0\0")
]


def decode(frames):
    """Return the gateware's decoding of each of ``frames``, None for a broken frame."""
    dut = shared(CobsDecoder)
    decoded = []

    async def send(ctx):
        ctx.set(dut.encoded.valid, 1)
        for value in b"".join(frame + b"\0" for frame in frames):
            ctx.set(dut.encoded.payload, value)
            await ctx.tick()
        ctx.set(dut.encoded.valid, 0)
        await ctx.tick().repeat(3)

    async def collect(ctx):
        part = bytearray()
        async for *_, valid, word in ctx.tick().sample(dut.decoded.valid, dut.decoded.payload):
            if valid and word.delimiter:
                decoded.append(None if word.broken else bytes(part))
                part.clear()
            elif valid:
                part.append(word.data)

    simulate(dut, send, background=[collect])
    return decoded


def decoded_by_package(frame):
    try:
        return cobs.decode(frame)
    except cobs.DecodeError:
        return None


def test_decodes_every_short_string():
    alphabet = (1, 2, 3, 4, 255)
    strings = [
        bytes(word) for length in range(1, 5) for word in itertools.product(alphabet, repeat=length)
    ]
    results = [decoded_by_package(frame) for frame in strings]
    assert None in results
    assert decode(strings) == results


def test_decodes_what_the_package_encodes():
    frames = LONG[::9] + SHORT[::7]
    assert decode([cobs.encode(frame) for frame in frames]) == frames


def test_skips_empty_frames():
    assert decode([b"", b"\2\7", b"", b"", b"\3", b"", b"\1"]) == [b"\7", None, b""]


def encode(frames, pauses=(0,), source_pauses=(0,)):
    """Return the encoded bytes of ``frames`` and their cycles."""
    dut = shared(CobsEncoder)
    taken = []

    async def send(ctx):
        words = [
            {"data": value, "last": i == len(frame) - 1}
            for frame in frames
            for i, value in enumerate(frame)
        ]
        await drive(ctx, dut.frames, words, source_pauses)
        expected = sum(len(cobs.encode(frame)) + 1 for frame in frames)
        for _ in range(2000):
            if len(taken) == expected:
                break
            await ctx.tick().repeat(max(pauses) + 1)
        await ctx.tick().repeat(10)

    simulate(dut, send, background=[watch(dut.encoded, taken, pauses)])
    return bytes(value for _, value in taken), [cycle for cycle, _ in taken]


@pytest.mark.parametrize(
    ("pauses", "source_pauses"),
    [((0,), (0,)), ((3, 0, 0, 1), (0,)), ((0,), (0, 0, 5))],
    ids=["steady", "slow line", "slow source"],
)
def test_encodes_as_the_package(pauses, source_pauses):
    frames = SHORT[:: 1 if pauses == source_pauses else 9] + LONG[::13]
    expected = b"".join(cobs.encode(frame) + b"\0" for frame in frames)
    assert encode(frames, pauses, source_pauses)[0] == expected


def test_encodes_random_frames_behind_a_full_buffer():
    rng = random.Random(7)
    frames = [
        bytes(rng.choice((0, rng.randrange(256), rng.randrange(1, 256))) for _ in range(length))
        for length in (600, 3, 1, 300)
    ]
    expected = b"".join(cobs.encode(frame) + b"\0" for frame in frames)
    assert encode(frames, pauses=(2,))[0] == expected


def test_leaves_no_pause_inside_a_frame():
    # The fastest line, 4 cycles per bit, accepts a byte every 40 cycles; 8 is stricter.
    _, cycles = encode([bytes(1 + i % 255 for i in range(520))], pauses=(7,))
    assert {after - before for before, after in itertools.pairwise(cycles)} == {8}


def test_latency_of_a_short_frame():
    # Bytes are accepted in cycles 0, 1 and 2; the code is offered 4 cycles after the last.
    _, cycles = encode([b"\1\2\3"])
    assert cycles[0] == 2 + 4
    assert cycles == list(range(6, 11))
