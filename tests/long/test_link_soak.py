"""Soak runs of the link: random bytes to the model, and a long session over a bad line."""

import random

import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import encode_frame
from pathgene.hdl.protocol.codes import Command, LinkMode
from pathgene.hdl.protocol.messages import info_reply
from pathgene.host.device.link import Link
from pathgene.sim.model.chip import Chip
from pathgene.sim.model.core import Limits
from pathgene.sim.model.requests import FrameReceiverModel
from tests.support.gateware.faults import ByteFaults, FaultyTransport, FrameFaults, VirtualClock


pytestmark = pytest.mark.long


def test_model_replies_after_twenty_million_random_bytes():
    rng = random.Random(29)
    model = FrameReceiverModel(Config())
    for _ in range(200):
        model.feed(rng.randbytes(100_000))
    assert len(model.verdicts) > 70_000
    assert model.feed(b"\0" + encode_frame(b"\1\2\3")) == [(b"\1\2\3", False)]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("faults", "rate"), [(ByteFaults, 1e-3), (FrameFaults, 0.05)])
def test_a_thousand_generations_over_a_bad_line(faults, rate, seed):
    rng = random.Random(seed)
    config = Config()
    chip, twin = Chip(config), Chip(config)
    clock = VirtualClock()
    port = FaultyTransport(
        chip.feed, clock, to_board=faults(rate, rng), from_board=faults(rate, rng)
    )
    link = Link(port, timeout_s=0.25, clock=clock)
    info = info_reply(config).unpack(link.info())
    link.open(info["session"], credit=info["receive_buffer"])

    assert link.request(Command.START, bytes(8) + b"\xff\1\xff\1\x80\x0c\0") == b""
    twin.core.start(0, Limits(511, 511, 0xC80))
    for generation in range(1, 1001):
        order = rng.sample(range(config.population), config.population)
        recipe = bytes((LinkMode.RECIPE, *order))
        assert link.request(Command.GENERATE, bytes((LinkMode.RANK, *order)), shorter=recipe)
        twin.core.run(order)
        if generation % 100 == 0:
            link.reopen()
    assert chip.core.generation == 1000
    assert chip.core.paths == twin.core.paths
