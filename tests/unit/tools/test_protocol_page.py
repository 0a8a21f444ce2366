"""The protocol's page and golden frames match the code and the model."""

import json

import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import FrameError, decode_frame, encode_frame
from pathgene.hdl.protocol.codes import Command, Status, StickyError
from pathgene.hdl.protocol.layout import Field, Layout, numbered
from pathgene.hdl.protocol.planner import VALUE_BITS
from pathgene.sim.model.chip import Chip
from tests.support.host.kernels import written_page
from tools.protocol_page import page
from tools.protocol_page.__main__ import FRAMES, PAGE
from tools.protocol_page.segments import split_reply, split_request


GOLDEN = json.loads(FRAMES.read_text())
CHIPS = {chip["name"]: chip for chip in GOLDEN["chips"]}


@pytest.mark.parametrize("path", [FRAMES, PAGE], ids=lambda path: path.name)
def test_committed_file(path):
    """`python -m tools.protocol_page` rewrites the files."""
    assert set(written_page()) == {FRAMES, PAGE}
    assert path.read_text() == written_page()[path]


@pytest.mark.parametrize("chip", CHIPS)
def test_model_gives_the_golden_replies(chip):
    model = Chip(Config(**CHIPS[chip]["config"]))
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
    done = {
        name: {
            exchange["request"]["command"]
            for exchange in chip["exchanges"]
            if exchange["reply"] and exchange["reply"]["status"] == "OK"
        }
        for name, chip in CHIPS.items()
    }
    runs = {"PROBLEM", "RUN", "STOP", "BEST", "BLOCK", "GUIDE", "CODED_MAP"}
    assert done["small"] == {command.name for command in Command} - runs
    assert done["planner"] > runs
    small = CHIPS["small"]["exchanges"]
    statuses = {exchange["reply"]["status"] for exchange in small if exchange["reply"]}
    # Runs of the model end immediately.
    assert statuses == {status.name for status in Status} - {"BUSY"}


def test_paths_of_a_run():
    """Both runs find paths, the second one past the shape that has been blocked."""
    best = {
        exchange["name"]: exchange["reply"]
        for exchange in CHIPS["planner"]["exchanges"]
        if exchange["request"].get("command") == "BEST"
    }
    assert "paths" not in best["BEST before"]
    for name in ("BEST", "BEST warm"):
        assert len(best[name]["paths"]) == len(best[name]["keys"]) > 1
        assert best[name]["keys"] == sorted(set(best[name]["keys"]))
        assert best[name]["keys"][0] < 1 << VALUE_BITS


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


def layout_table(monkeypatch, layout):
    """Return the lines of the page's table of a new message."""
    monkeypatch.setitem(page.MESSAGES, "new_request", lambda config: layout)
    return page._layout_table("new_request").splitlines()


def test_a_new_message_has_its_table_from_its_fields(monkeypatch):
    """The table needs only the fields of the recipe "Add a message"."""
    slots = numbered("slot", 3, 8, "any", "Slots to move")
    assert layout_table(monkeypatch, Layout((Field("mode", 8, "0, 1", "1: move"), *slots))) == [
        "4 bytes:",
        "",
        "| Byte | Bits | Field | Values | Meaning |",
        "| --- | --- | --- | --- | --- |",
        "| 0 | 8 | `mode` | 0, 1 | 1: move |",
        "| 1 + i | 8 | `slot_i`, i = 0 … 2 | any | Slots to move |",
    ]


@pytest.mark.parametrize(
    ("field", "sentence"),
    [
        (("mode", 8), r"^Fields of new_request must have texts, unlike mode$"),
        (
            Field("x", 7, "any", "Column", "altitude_bits"),
            r"^Width of new_request\.x must be altitude_bits, not 7$",
        ),
    ],
)
def test_a_field_without_a_text_or_of_another_width_is_refused(monkeypatch, field, sentence):
    with pytest.raises(ValueError, match=sentence):
        layout_table(monkeypatch, Layout((field,)))
