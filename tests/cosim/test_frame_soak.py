"""The exported frame receiver in Verilator, compared with the model on long streams of bytes."""

import random
import subprocess
from pathlib import Path

import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.link.frame import FrameReceiver
from pathgene.hdl.protocol.codec import encode_frame
from pathgene.hdl.protocol.codes import StickyError
from pathgene.hdl.verilog import convert
from pathgene.sim.cache import BuildCache, build_root
from pathgene.sim.exported import cached_verilog
from pathgene.sim.model.requests import FrameReceiverModel
from pathgene.sim.verilator import build_verilator
from tests.support.gateware.faults import ByteFaults


pytestmark = pytest.mark.cosim

CONFIG = Config(receive_buffer=256)
GOOD = b"\0" + encode_frame(b"still there")
LETTERS = {"M": StickyError.MALFORMED, "C": StickyError.CRC, "O": StickyError.OVERRUN}


def receive(data, longest_pause=0):
    """Return the frames and verdicts of the exported receiver, and whether the line is busy."""
    text = cached_verilog(
        lambda: convert(FrameReceiver(CONFIG.receive_buffer), "frame_receiver"),
        "frame_receiver",
        repr(CONFIG),
    )
    program = build_verilator(
        BuildCache(build_root() / "sim"),
        text,
        "frame_receiver",
        main=Path(__file__).with_name("frame_soak.cpp"),
    )
    done = subprocess.run(
        [program, str(longest_pause)], input=data, stdout=subprocess.PIPE, check=True
    )
    *lines, busy = done.stdout.decode().splitlines()
    frames = [(bytes.fromhex(line[1:]), line[0] == "P") for line in lines if line[0] in "FP"]
    return frames, [LETTERS[line] for line in lines if line in LETTERS], busy == "busy 1"


def mixed(rng, size):
    """Return frames of all lengths over a bad line, with garbage between them."""
    faults = ByteFaults(3e-4, rng)
    data = bytearray()
    while len(data) < size:
        length = rng.choice((3, 4, rng.randrange(3, 64), rng.randrange(240, 260)))
        body = bytes(rng.choice((0, rng.randrange(256))) for _ in range(length))
        data += faults(encode_frame(body, plain=rng.random() < 0.2))
        if rng.random() < 0.1:
            data += rng.randbytes(rng.randrange(40))
    return bytes(data) + GOOD


@pytest.mark.parametrize(
    "size", [100_000, pytest.param(1_000_000, marks=pytest.mark.long)], ids=["short", "long"]
)
@pytest.mark.parametrize("kind", ["random", "mixed"])
def test_matches_the_model_on_long_streams(kind, size):
    rng = random.Random(size)
    data = rng.randbytes(size) + GOOD if kind == "random" else mixed(rng, size)
    model = FrameReceiverModel(CONFIG)
    expected = model.feed(data)
    frames, verdicts, busy = receive(data)
    assert frames == expected
    assert verdicts == model.verdicts
    assert busy == model.line_busy
    assert frames[-1] == (b"still there", False)
    if kind == "mixed":
        assert set(verdicts) == set(LETTERS.values())
        assert len(frames) > size // 200


def test_loses_only_whole_frames_when_the_reader_is_slow():
    rng = random.Random(8)
    data = mixed(rng, 60_000)
    model = FrameReceiverModel(CONFIG)
    sent = model.feed(data)
    frames, verdicts, _ = receive(data, longest_pause=400)
    # Lost frames are counted, and all further frames are in order.
    assert frames
    rest = iter(sent)
    assert all(frame in rest for frame in frames)
    lost = verdicts.count(StickyError.OVERRUN) - model.verdicts.count(StickyError.OVERRUN)
    assert lost == len(sent) - len(frames) > 50
    others = [kind for kind in verdicts if kind is not StickyError.OVERRUN]
    assert others == [kind for kind in model.verdicts if kind is not StickyError.OVERRUN]
