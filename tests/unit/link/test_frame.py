"""Frame receiver and transmitter, compared with the model."""

import itertools
import random

import pytest
from cobs import cobs

from pathgene.hdl.config import Config
from pathgene.hdl.link.frame import FrameReceiver, FrameTransmitter
from pathgene.hdl.protocol.codec import encode_frame, frame_crc
from pathgene.hdl.protocol.codes import StickyError
from pathgene.sim.model.requests import FrameReceiverModel
from tests.support.gateware.streams import drive, shared, simulate, watch


CONFIG = Config(receive_buffer=256)
ERRORS = {
    "malformed": StickyError.MALFORMED,
    "crc_error": StickyError.CRC,
    "overrun": StickyError.OVERRUN,
}


def pattern(length, seed):
    """Return bytes whose nonzero runs are often longer than a COBS block."""
    rng = random.Random(seed)
    return bytes(0 if rng.random() < 0.003 else rng.randrange(1, 256) for _ in range(length))


class Receiver:
    """Bench of a receiver that records its frames and errors in order, with their cycles."""

    def __init__(self, config=CONFIG, pauses=(0,)):
        self.dut = shared(FrameReceiver, config.receive_buffer)
        self.pauses = pauses
        self.words = []
        self.errors = []
        self.cycle = 0

    def run(self, *scenario):
        simulate(
            self.dut,
            *scenario,
            background=[watch(self.dut.requests, self.words, self.pauses), self._watch_errors],
        )
        return self

    async def _watch_errors(self, ctx):
        signals = [getattr(self.dut, name) for name in ERRORS]
        async for *_, malformed, crc_error, overrun in ctx.tick().sample(*signals):
            raised = zip(ERRORS.values(), (malformed, crc_error, overrun), strict=True)
            self.errors += [(self.cycle, error) for error, high in raised if high]
            self.cycle += 1

    async def feed(self, ctx, data):
        """Send a byte per cycle and check that the receiver is always ready."""
        ctx.set(self.dut.bytes.valid, 1)
        for value in data:
            assert ctx.get(self.dut.bytes.ready)
            ctx.set(self.dut.bytes.payload, value)
            await ctx.tick()
        ctx.set(self.dut.bytes.valid, 0)

    async def drain(self, ctx):
        """Wait until no word has been output for a while."""
        seen = None
        while seen != len(self.words):
            seen = len(self.words)
            await ctx.tick().repeat(max(self.pauses) + 8)

    @property
    def frames(self):
        frames, body = [], bytearray()
        for _, word in self.words:
            body.append(word.data)
            if word.last:
                frames.append((bytes(body), bool(word.plain)))
                body.clear()
        assert not body
        return frames


def receive(data, config=CONFIG, pauses=(0,)):
    receiver = Receiver(config, pauses)

    async def scenario(ctx):
        await receiver.feed(ctx, data)
        await receiver.drain(ctx)

    return receiver.run(scenario)


def check_against_model(data, config=CONFIG, pauses=(0,)):
    model = FrameReceiverModel(config)
    expected = model.feed(data)
    receiver = receive(data, config, pauses)
    assert receiver.frames == expected
    assert [error for _, error in receiver.errors] == model.verdicts
    return expected, model.verdicts


def test_receives_every_short_body():
    bodies = [
        bytes(body) for length in (3, 4) for body in itertools.product((0, 1, 255), repeat=length)
    ]
    data = b"".join(encode_frame(body, plain=plain) for body in bodies for plain in (False, True))
    frames, verdicts = check_against_model(data)
    assert frames == [(body, plain) for body in bodies for plain in (False, True)]
    assert verdicts == []


def test_receives_behind_every_short_garbage():
    good = encode_frame(b"\1\2\3")
    pieces = [
        bytes(garbage) + b"\0"
        for length in range(4)
        for garbage in itertools.product((0, 1, 2, 4, 255), repeat=length)
    ]
    frames, verdicts = check_against_model(b"".join(pieces[::2]) + good)
    assert frames == [(b"\1\2\3", False)]
    assert set(verdicts) == {StickyError.MALFORMED}


@pytest.mark.parametrize("pauses", [(0,), (0, 1, 0, 2)], ids=["steady", "stalled"])
def test_receives_bodies_around_a_block(pauses):
    # Delimiters between the frames allow the reader to keep up.
    bodies = [pattern(length, length) for length in (249, 250, 251, 255)]
    data = b"".join(encode_frame(body) + b"\0" * 200 * max(pauses) for body in bodies)
    frames, verdicts = check_against_model(data, pauses=pauses)
    assert frames == [(body, False) for body in bodies]
    assert verdicts == []


def test_receives_long_bodies():
    config = Config(receive_buffer=1024)
    bodies = [pattern(length, length) for length in (505, 1020, 1023)]
    data = b"".join(encode_frame(body, plain=True) for body in bodies)
    frames, _ = check_against_model(data, config)
    assert frames == [(body, True) for body in bodies]


def test_drops_a_body_longer_than_the_buffer():
    good = encode_frame(b"abc")
    data = b"".join(encode_frame(pattern(length, 1)) + good for length in (255, 256, 257, 600))
    frames, verdicts = check_against_model(data)
    assert [len(body) for body, _ in frames] == [255, 3, 3, 3, 3]
    assert verdicts == [StickyError.OVERRUN] * 3


def test_reports_the_first_rule_a_frame_breaks():
    body = b"\1\2\3\4"
    crc = frame_crc(body, plain=False)
    pieces = [
        (b"\7", StickyError.MALFORMED),
        (cobs.encode(body[:2] + bytes(4)), StickyError.MALFORMED),
        (cobs.encode(body[:3] + bytes(4)), StickyError.CRC),
        (cobs.encode(body + (crc ^ 0x5A).to_bytes(4, "little")), StickyError.CRC),
        (cobs.encode(body + (crc ^ 1 << 31).to_bytes(4, "little")), StickyError.CRC),
        (encode_frame(body)[:-2], StickyError.MALFORMED),
        (cobs.encode(bytes(400)), StickyError.CRC),
        (encode_frame(bytes(400))[:-1], StickyError.OVERRUN),
        (encode_frame(bytes(400))[:-1] + b"\2", StickyError.MALFORMED),
    ]
    _, verdicts = check_against_model(b"".join(piece + b"\0" for piece, _ in pieces))
    assert verdicts == [kind for _, kind in pieces]


def test_a_frame_with_any_bit_flipped_is_not_received():
    frame = encode_frame(b"\0\1\2")
    flipped = [
        bytes(value ^ (1 << bit if i == at else 0) for i, value in enumerate(frame))
        for at in range(len(frame))
        for bit in range(8)
    ]
    frames, _ = check_against_model(b"".join(data + b"\0" for data in flipped) + frame)
    # The version is one of the bits: without it, the frame is a plain one.
    assert [body for body, plain in frames if not plain] == [b"\0\1\2"]


def test_receives_after_random_bytes():
    rng = random.Random(11)
    data = bytearray()
    for number in range(30):
        # Some complete codes, so that garbage reaches the CRC check.
        garbage = bytes(rng.choice((1, rng.randrange(5), rng.randrange(256))) for _ in range(40))
        data += cobs.encode(garbage) if number % 3 == 0 else garbage
        data += b"\0" + encode_frame(bytes([number, 0, rng.randrange(256)]))
    frames, verdicts = check_against_model(bytes(data))
    assert [body[0] for body, _ in frames] == list(range(30))
    assert set(verdicts) == {StickyError.MALFORMED, StickyError.CRC}


@pytest.mark.parametrize("size", [3, 60, 252])
def test_bodies_with_crcs_up_to_the_buffer_always_fit(size):
    # Three rounds, each of which fills the buffer before any read, for several pointer positions.
    receiver = Receiver()
    count = CONFIG.receive_buffer // (size + 4)
    rounds = [
        [bytes([number]) * size for number in range(first, first + count)] for first in (1, 90, 180)
    ]

    async def scenario(ctx):
        for bodies in rounds:
            await receiver.feed(ctx, b"".join(map(encode_frame, bodies)))
            await receiver.drain(ctx)

    # There is a pause before each first byte, longer than it takes to fill the buffer.
    total = size * count
    receiver.pauses = [700, *[0] * (total - 1)]
    receiver.run(scenario)
    assert receiver.frames == [(body, False) for bodies in rounds for body in bodies]
    assert receiver.errors == []


def test_an_overrun_loses_only_frames_that_do_not_fit():
    receiver = Receiver(pauses=[900, *[0] * 1000])
    bodies = [bytes([number]) * 60 for number in range(1, 7)]

    async def scenario(ctx):
        await receiver.feed(ctx, b"".join(map(encode_frame, bodies)))
        await receiver.drain(ctx)
        await receiver.feed(ctx, encode_frame(b"after"))
        await receiver.drain(ctx)

    receiver.run(scenario)
    # 4 bodies take 244 rows and two more rows are read ahead; the fifth finds no room.
    assert receiver.frames == [(body, False) for body in [*bodies[:4], b"after"]]
    assert [error for _, error in receiver.errors] == [StickyError.OVERRUN] * 2


def test_latency():
    frame = encode_frame(b"\1\2\3\4")
    receiver = receive(frame + b"\7\0")
    delimiter = len(frame) - 1
    assert [cycle for cycle, _ in receiver.words] == [delimiter + 6 + i for i in range(4)]
    assert receiver.errors == [(delimiter + 2 + 2, StickyError.MALFORMED)]


def test_line_is_busy_inside_a_frame():
    dut = shared(FrameReceiver, CONFIG.receive_buffer)
    busy = []

    async def scenario(ctx):
        ctx.set(dut.bytes.valid, 1)
        for value in (0, 3, 0, 0, 1, 1):
            ctx.set(dut.bytes.payload, value)
            await ctx.tick()
            busy.append(ctx.get(dut.line_busy))

    simulate(dut, scenario)
    assert busy == [0, 1, 0, 0, 1, 1]


def transmit(bodies, pauses=(0,), source_pauses=(0,)):
    """Return the bytes of the frames of ``bodies`` and their cycles."""
    dut = shared(FrameTransmitter)
    taken = []

    async def send(ctx):
        words = [
            {"data": value, "last": i == len(body) - 1, "plain": plain}
            for body, plain in bodies
            for i, value in enumerate(body)
        ]
        await drive(ctx, dut.replies, words, source_pauses)
        seen = None
        while seen != len(taken):
            seen = len(taken)
            await ctx.tick().repeat(20 + max(pauses))

    simulate(dut, send, background=[watch(dut.bytes, taken, pauses)])
    return bytes(value for _, value in taken), [cycle for cycle, _ in taken]


def frames_of(bodies):
    parts = []
    for body, plain in bodies:
        crc = frame_crc(body, plain=plain).to_bytes(4, "little")
        parts.append(cobs.encode(body + crc) + b"\0")
    return b"".join(parts)


@pytest.mark.parametrize(
    ("pauses", "source_pauses"),
    [((0,), (0,)), ((2, 0, 1), (0,)), ((0,), (0, 4))],
    ids=["steady", "slow line", "slow source"],
)
def test_transmits_every_length(pauses, source_pauses):
    lengths = [*range(1, 9), *range(249, 252), 505]
    bodies = [(pattern(length, length), length % 2 == 0) for length in lengths]
    bodies += [(bytes(length), False) for length in (1, 3, 254)]
    assert transmit(bodies, pauses, source_pauses)[0] == frames_of(bodies)


def test_transmits_frames_the_receiver_accepts():
    bodies = [(pattern(length, length), length % 3 == 0) for length in (3, 4, 100, 251)]
    data, _ = transmit(bodies)
    assert receive(data).frames == bodies


def test_transmitter_latency():
    # The body is accepted in cycles 0 to 2.
    _, cycles = transmit([(b"\1\2\3", False)])
    assert cycles == list(range(2 + 8, 2 + 8 + 9))


def test_transmitter_leaves_no_pause_between_frames():
    # 8 cycles per byte: a fifth of the time on the fastest line.
    bodies = [(pattern(length, 5), False) for length in (260, 20, 20)]
    _, cycles = transmit(bodies, pauses=(7,))
    assert {after - before for before, after in itertools.pairwise(cycles)} == {8}
