"""Frames in software: the codec of host and model, and the model of the receiver."""

import random
import time

import pytest
from cobs import cobs
from hypothesis import given
from hypothesis import strategies as st

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import FrameError, FrameSplitter, decode_frame, encode_frame
from pathgene.hdl.protocol.codes import StickyError
from pathgene.sim.model.requests import FrameReceiverModel


BODIES = st.binary(min_size=3, max_size=600)


def test_a_plain_frame_by_hand():
    # 0xCBF43926 is the check value in the definition of this CRC.
    frame = encode_frame(b"123456789", plain=True)
    assert frame == bytes([14]) + b"123456789" + bytes([0x26, 0x39, 0xF4, 0xCB, 0])


@given(BODIES, st.booleans())
def test_decodes_what_it_encodes(body, plain):
    frame = encode_frame(body, plain=plain)
    assert frame.index(0) == len(frame) - 1
    assert len(frame) <= len(body) + 4 + 2 + (len(body) + 4) // 254
    assert decode_frame(frame[:-1]) == (body, plain)


def test_a_body_needs_its_header():
    with pytest.raises(ValueError, match=r"^Body must have 3 bytes or more, not 2$"):
        encode_frame(b"\1\2")


@pytest.mark.parametrize(
    ("encoded", "kind", "sentence"),
    [
        (b"\5\1", StickyError.MALFORMED, "Frame must have a right COBS code or length"),
        (b"\1\1\1\1\1\1", StickyError.MALFORMED, "Frame must have a right COBS code or length"),
        (b"\1\1\1\1\1\1\1\1", StickyError.CRC, "Frame must have a right CRC"),
    ],
)
def test_names_the_fault_of_a_frame(encoded, kind, sentence):
    with pytest.raises(FrameError, match=f"^{sentence}$") as caught:
        decode_frame(encoded)
    assert caught.value.kind is kind


@given(st.lists(st.binary(max_size=20)), st.randoms(use_true_random=False))
def test_splits_a_stream_in_any_pieces(pieces, rng):
    data = b"\0".join(pieces)
    splitter, ended = FrameSplitter(), []
    at = 0
    while at < len(data):
        size = rng.randrange(1, 9)
        ended += splitter.feed(data[at : at + size])
        at += size
    expected = data.split(b"\0")
    assert ended == [piece for piece in expected[:-1] if piece]
    assert splitter.inside == bool(expected[-1])


def test_drops_a_partial_frame():
    splitter = FrameSplitter()
    assert splitter.feed(b"\1\0\2\3") == [b"\1"]
    splitter.drop()
    assert not splitter.inside
    assert splitter.feed(b"\4\0\0\0") == [b"\4"]


@given(st.lists(st.one_of(st.binary(max_size=12), BODIES.map(encode_frame))), st.integers(1, 40))
def test_the_model_replies_equally_to_any_pieces(parts, size):
    data = b"".join(parts)
    whole, pieced = FrameReceiverModel(Config()), FrameReceiverModel(Config())
    expected = whole.feed(data)
    received = [
        frame for at in range(0, len(data), size) for frame in pieced.feed(data[at : at + size])
    ]
    assert received == expected
    assert pieced.verdicts == whole.verdicts
    assert pieced.line_busy == whole.line_busy


def test_the_model_drops_frames_longer_than_the_buffer():
    model = FrameReceiverModel(Config(receive_buffer=256))
    assert model.longest_body == 255
    assert model.feed(encode_frame(bytes(255))) == [(bytes(255), False)]
    assert model.feed(encode_frame(bytes(256))) == []
    assert model.feed(b"\7\0" + cobs.encode(bytes(9)) + b"\0") == []
    assert model.verdicts == [StickyError.OVERRUN, StickyError.MALFORMED, StickyError.CRC]
    assert model.errors == StickyError.OVERRUN | StickyError.MALFORMED | StickyError.CRC


def test_the_model_replies_after_two_million_random_bytes():
    rng = random.Random(23)
    model = FrameReceiverModel(Config())
    start = time.perf_counter()
    for _ in range(20):
        model.feed(rng.randbytes(100_000))
    # One of the 7,800 frames has a valid CRC with a probability of 1 in 500,000.
    assert len(model.verdicts) > 7000
    assert model.feed(b"\0" + encode_frame(b"\1\2\3")) == [(b"\1\2\3", False)]
    # At this rate, the 20 MB of the long run take less than a minute.
    assert time.perf_counter() - start < 6
