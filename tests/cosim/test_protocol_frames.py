"""The gateware answers the golden frames of docs/protocol_frames.json."""

import json
from pathlib import Path

import pytest

from hdl.config import Config
from hdl.protocol import DELIMITER, Command, counters_reply
from hdl.protocol.codec import decode_frame
from sim.board.scheme import start_simulated
from tests.chips import board_url


pytestmark = pytest.mark.cosim

GOLDEN = json.loads(
    (Path(__file__).resolve().parents[2] / "docs" / "protocol_frames.json").read_text()
)


def test_gateware_gives_the_golden_replies():
    chip = GOLDEN["chips"][0]
    config = Config(**chip["config"])
    with start_simulated(board_url("sim", config)) as board, board.open(timeout=30) as port:
        assert chip["exchanges"][-1]["reply"] is not None
        for exchange in chip["exchanges"]:
            port.write(bytes.fromhex(exchange["request"]["frame"]))
            if exchange["reply"] is None:
                continue  # A reply would precede that to the next request and fail there.
            replied = bytearray()
            while not replied.endswith(bytes([DELIMITER])):
                byte = port.read(1)
                assert byte, exchange["name"]
                replied += byte
            expected = bytes.fromhex(exchange["reply"]["frame"])
            if exchange["request"].get("command") == Command.COUNTERS.name:
                assert counters_of(config, replied) == counters_of(config, expected)
            else:
                assert replied.hex() == expected.hex(), exchange["name"]


def counters_of(config, frame):
    """Return the counters in a reply, without those that differ slightly between boards."""
    body, _ = decode_frame(bytes(frame[:-1]))
    values = counters_reply(config).unpack(body[3:])
    return {name: count for name, count in values.items() if name not in GOLDEN["timed"]}
