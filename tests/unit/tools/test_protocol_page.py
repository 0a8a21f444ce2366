"""The protocol's page and golden frames match the code and the model."""

import json

import pytest

from hdl.config import Config
from hdl.protocol import Command, Status, StickyError
from hdl.protocol.codec import FrameError, decode_frame, encode_frame
from sim.model.chip import ChipModel
from tools.protocol_page.files import FRAMES, contents
from tools.protocol_page.segments import split_reply, split_request


GOLDEN = json.loads(FRAMES.read_text())
CHIPS = {chip["name"]: chip for chip in GOLDEN["chips"]}


@pytest.mark.parametrize("path", contents(), ids=lambda path: path.name)
def test_committed_file(path):
    """`python -m tools.protocol_page` rewrites the files."""
    assert path.read_text() == contents()[path]


@pytest.mark.parametrize("chip", CHIPS)
def test_model_gives_the_golden_replies(chip):
    model = ChipModel(Config(**CHIPS[chip]["config"]))
    assert CHIPS[chip]["exchanges"]
    for exchange in CHIPS[chip]["exchanges"]:
        replied = model.feed(bytes.fromhex(exchange["request"]["frame"]))
        expected = exchange["reply"]["frame"] if exchange["reply"] else ""
        assert replied.hex() == expected, exchange["name"]


@pytest.mark.parametrize("chip", CHIPS)
def test_bodies_match_the_frames(chip):
    for exchange in CHIPS[chip]["exchanges"]:
        for said in (exchange["request"], exchange["reply"]):
            if said and "body" in said:
                body = bytes.fromhex(said["body"])
                assert encode_frame(body, plain=said["plain"]).hex() == said["frame"]
                assert list(body[:3]) == [said["session"], said["sequence"], said["code"]]


def test_every_command_and_every_status():
    exchanges = CHIPS["small"]["exchanges"]
    done = {
        exchange["request"]["command"]
        for exchange in exchanges
        if exchange["reply"] and exchange["reply"]["status"] == "OK"
    }
    # Of the streaming core there is a model only; its frames come with its gateware.
    streaming = {"PROBLEM", "RUN", "STOP", "BEST"}
    assert done == {command.name for command in Command} - streaming
    statuses = {exchange["reply"]["status"] for exchange in exchanges if exchange["reply"]}
    assert statuses == {status.name for status in Status}


def test_damaged_frames():
    """The receiver drops every frame without a body."""
    kinds = []
    for exchange in CHIPS["small"]["exchanges"]:
        if "body" not in exchange["request"]:
            with pytest.raises(FrameError) as caught:
                decode_frame(bytes.fromhex(exchange["request"]["frame"])[:-1])
            kinds.append(caught.value.kind)
    assert kinds == [StickyError.CRC, StickyError.MALFORMED, StickyError.MALFORMED]


def test_a_payload_without_a_layout_is_no_payload_of_the_page():
    config = Config()
    assert split_request(config, Command.OPEN, b"") == []
    assert split_reply(config, Command.OPEN, b"", b"") == []
    with pytest.raises(ValueError, match=r"^The request OPEN has a payload, of which no layout is"):
        split_request(config, Command.OPEN, b"1")
    with pytest.raises(ValueError, match=r"^The reply OPEN has a payload, of which no layout is"):
        split_reply(config, Command.OPEN, b"", b"1")
