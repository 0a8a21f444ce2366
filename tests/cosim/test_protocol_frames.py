"""The gateware answers the golden frames of docs/protocol_frames.json."""

import json
from pathlib import Path

import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import DELIMITER, decode_frame, encode_frame
from pathgene.hdl.protocol.codes import Command, Counter
from pathgene.hdl.protocol.messages import counters_reply
from pathgene.sim.board.scheme import start_simulated
from tools.chips import board_url


pytestmark = pytest.mark.cosim

GOLDEN = json.loads(
    (Path(__file__).resolve().parents[2] / "docs" / "protocol_frames.json").read_text()
)


#: Plain frames that pass the time of a run, of 100,000 cycles at most.
WAITING = encode_frame(bytes((0, 0, Command.INFO)), plain=True) * 60


@pytest.mark.parametrize("name", ["small", pytest.param("planner", marks=pytest.mark.ci)])
def test_gateware_gives_the_golden_replies(name):
    [chip] = (chip for chip in GOLDEN["chips"] if chip["name"] == name)
    config = Config(**chip["config"])
    with start_simulated(board_url("sim", config)) as board, board.open(timeout=30) as port:
        assert chip["exchanges"][-1]["reply"] is not None
        for exchange in chip["exchanges"]:
            port.write(bytes.fromhex(exchange["request"]["frame"]))
            if exchange["reply"] is None:
                continue  # A reply would precede the reply to the next request and fail there.
            replied = reply(port)
            if exchange["request"].get("command") == Command.RUN.name:
                # A few at a time, so that they fit into the receive buffer.
                for waiting in WAITING.split(bytes([DELIMITER]))[:-1]:
                    port.write(waiting + bytes([DELIMITER]))
                    reply(port)
            expected = bytes.fromhex(exchange["reply"]["frame"])
            if exchange["request"].get("command") == Command.COUNTERS.name:
                assert counters_of(config, replied, name) == counters_of(config, expected, name)
            else:
                assert replied.hex() == expected.hex(), exchange["name"]


def reply(port):
    """Return the next frame from the board."""
    replied = bytearray()
    while not replied.endswith(bytes([DELIMITER])):
        byte = port.read(1)
        assert byte
        replied += byte
    return replied


def counters_of(config, frame, name):
    """Return the counters in a reply, without those that differ between boards."""
    waited = (Counter.BYTES_RECEIVED, Counter.BYTES_SENT) if name == "planner" else ()
    body, _ = decode_frame(bytes(frame[:-1]))
    values = counters_reply(config).unpack(body[3:])
    return {
        name: count for name, count in values.items() if name not in (*GOLDEN["timed"], *waited)
    }
