"""Sends the frames of ``frame_mix`` to the model, then to a simulated board.

A failure names its seed and its frame, and the command that repeats it:
``python -m tests.support.gateware.command_fuzz CHIP SEED FRAMES [--board]``.
"""

import argparse
import collections
import functools

import numpy as np

from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, FrameSplitter, decode_frame, encode_frame
from pathgene.hdl.protocol.codes import CheckFlag, Command, LinkMode, Status
from pathgene.hdl.protocol.messages import (
    check_paths_request,
    check_request,
    counters_reply,
    read_request,
    results_request,
    start_request,
    status_reply,
)
from pathgene.hdl.protocol.paths import pack_paths
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.device.chip_map import map_frames
from pathgene.sim.board.scheme import start_simulated
from pathgene.sim.model.chip import Chip
from tests.support.gateware.chips import CHECKERS, LINE_CYCLES
from tests.support.gateware.frame_mix import KINDS, FrameMix
from tests.support.gateware.protocol_rules import ProtocolRules
from tests.support.planner.cases import SMALL, ground, record, shape
from tools.chips import board_url


#: The two kinds of chips: with the paper core and a checker, and with the planner core.
CHIPS = {
    "paper": CHECKERS["parallel"],
    "planner": SMALL.replace(clocks_per_bit=4, receive_buffer=512),
}
#: Frames between two valid sessions.
_INTERVAL = 500
#: Maximum number of polls until a run is over.
_LOOKS = 10_000


class CommandFuzz:
    """A chip that gets random frames and valid sessions, as a model and optionally as a board.

    Parameters
    ----------
    chip : str
        One of :data:`CHIPS`.
    port : serial port, optional
        A board of the same chip after its reset.

    Attributes
    ----------
    counts : collections.Counter
        Frames by kind and status; None if unanswered.
    """

    def __init__(self, chip, seed, port=None):
        self.chip, self.seed = chip, seed
        self.config = config = CHIPS[chip]
        self.counts = collections.Counter()
        self.rules = ProtocolRules(config)
        self.mix = FrameMix(config, self.rules, seed)
        self.model = Chip(config)
        self._port = port
        # Before it is written, a map holds arbitrary data.
        self.command(Command.OPEN)
        for payload in self._map(seed):
            self.command(Command.MAP, payload)

    def run(self, frames):
        """Exchange the given number of frames, with valid sessions between and after them."""
        for frame in range(1, frames + 1):
            kind, body, plain = self.mix.draw()
            try:
                status = self.exchange(body, plain)[0]
                if frame % _INTERVAL == 0 or frame == frames:
                    self.compare_state()
                    assert self.session() == fault_free(self.chip)
            except Exception as error:
                again = (
                    f"python -m tests.support.gateware.command_fuzz {self.chip} {self.seed} {frame}"
                )
                raise AssertionError(
                    f"frame {frame} of seed {self.seed}, {kind}, plain {plain}: {body.hex(' ')}; "
                    f"again by: {again}{' --board' if self._port else ''}"
                ) from error
            self.counts[kind, status] += 1

    def exchange(self, body, plain=False):
        """Send a frame and wait for the end of a run; return the status, if any, and the answer."""
        frame = encode_frame(body, plain=plain)
        expected = self.model.feed(frame)
        answer = answer_in(expected, plain)
        status = self.rules.judge(body, plain, answer)
        if self._port:
            self._port.write(frame)
            told = self._port.read(len(expected))
            if body[2] == Command.COUNTERS and status is Status.OK:
                told, expected = map(self._without_line_cycles, (told, expected))
            assert told == expected, f"answer {told.hex(' ')}, not {expected.hex(' ')}"
            if body[2] == Command.RUN and status is Status.OK:
                self.await_end()
        if body[2] == Command.WRITE and status in (Status.BAD_LENGTH, Status.BAD_VALUE):
            # The slots that it names hold arbitrary paths now.
            self.command(Command.WRITE, self.mix.paths())
        return status, answer

    def command(self, code, payload=b""):
        """Execute a valid command; return the payload of its answer."""
        session = (self.rules.session + (code == Command.OPEN)) % 256
        body = bytes((session, self.rules.expected, code)) + payload
        status, answer = self.exchange(body, plain=code == Command.INFO)
        assert status is Status.OK, (code, status)
        return answer[BODY_HEADER_BYTES:]

    def await_end(self):
        """Ask board and model for the status until the board's run is over; then compare it."""
        layout = status_reply(self.config)
        for _ in range(_LOOKS):
            body = bytes((self.rules.session, self.rules.expected, Command.STATUS))
            frame = encode_frame(body)
            self._port.write(frame)
            expected = self.model.feed(frame)
            self.rules.judge(body, False, answer_in(expected, False))
            told = self._port.read(len(expected))
            assert len(told) == len(expected), told.hex(" ")
            if not layout.unpack(answer_in(told, False)[BODY_HEADER_BYTES:])["running"]:
                assert told == expected, f"answer {told.hex(' ')}, not {expected.hex(' ')}"
                return
        raise TimeoutError(f"Run must end within {_LOOKS} looks")

    def compare_state(self):
        """Send commands whose answers show population, map and counters."""
        requests = [(Command.STATUS, b""), (Command.COUNTERS, b"")]
        if self.config.planner_core:
            warm = RunOptions(
                generations=2, warm=True, slopes=(), seeds=8, give_up_rank=3, cycles=1 << 17
            )
            requests += [
                (Command.BEST, b""),
                (Command.RUN, warm.pack(self.config)),
                *plan_on_the_map(self.config),
            ]
        else:
            size = self.config.population
            requests.append((Command.READ, read_request(self.config).pack(slot=0, count=size)))
            requests += scan_of_the_map(self.config)
        for code, payload in requests:
            self.exchange(bytes((self.rules.session, self.rules.expected, code)) + payload)

    def session(self):
        """Open a session, use every function of the chip, and return the answers."""
        self.command(Command.INFO)
        self.command(Command.OPEN)
        return [self.command(code, payload) for code, payload in valid_requests(self.chip)]

    def _map(self, seed):
        edge, top = self.config.map_size, self.config.blocked_altitude
        heights = np.random.default_rng(seed).integers(0, top // 2, (edge, edge))
        return [payload for payload, _ in map_frames(self.config, heights, 0, 0)]

    def _without_line_cycles(self, frame):
        layout = counters_reply(self.config)
        answer = answer_in(frame, False)
        counters = layout.unpack(answer[BODY_HEADER_BYTES:]) | dict.fromkeys(LINE_CYCLES, 0)
        return answer[:BODY_HEADER_BYTES] + layout.pack(**counters)


def answer_in(data, plain):
    """Return the body of the single frame in ``data``, or None if there is none."""
    frames = FrameSplitter().feed(data)
    if not frames:
        return None
    ((body, told_plain),) = map(decode_frame, frames)
    assert told_plain == plain
    return body


@functools.cache
def valid_requests(chip):
    """Return commands and payloads of a short session that uses each unit of the chip."""
    config = CHIPS[chip]
    rng = np.random.default_rng(1)
    heights = ground(config, rng)
    maps = [(Command.MAP, payload) for payload, _ in map_frames(config, heights, 0, 0)]
    if config.planner_core:
        block = (Command.BLOCK, shape(config, rng, span=4).pack(config))
        return [(Command.CLEAR, b""), *maps, block, *plan_on_the_map(config), (Command.STATUS, b"")]
    size = config.population
    paths = [[17 * slot + i for i in range(2 + slot % 4)] for slot in range(size)]
    order = bytes(reversed(range(size)))
    start = start_request(config).pack(seed=5, x=15, y=15, altitude=14, avoid_ground=1)
    both = check_paths_request(config).pack(
        slot=0, count=size, flags=CheckFlag.COUNT, start=0, goal=0xFF
    )
    return [
        (Command.CLEAR, b""),
        *maps,
        (Command.START, start),
        (Command.WRITE, b"\0" + pack_paths(config, paths)),
        *((Command.GENERATE, bytes([mode]) + order) for mode in (LinkMode.RANK, LinkMode.RECIPE)),
        (Command.GENERATE, bytes([LinkMode.POPULATION])),
        (Command.READ, read_request(config).pack(slot=0, count=size)),
        (Command.CHECK_PATHS, both),
        (Command.RESULTS, results_request(config).pack(path=2, count=3)),
        *scan_of_the_map(config)[:2],
        (Command.STATUS, b""),
    ]


def plan_on_the_map(config):
    """Return a problem and a cold run on the current map."""
    options = RunOptions(seed=5, generations=3, seeds=8, give_up_rank=3, cycles=1 << 17)
    problem = record(config, np.random.default_rng(2))
    return [
        (Command.PROBLEM, problem.pack(config)),
        (Command.RUN, options.pack(config)),
        (Command.BEST, b""),
    ]


def scan_of_the_map(config):
    """Return a CHECK of each row of the map, which counts the cells above the path."""
    count = check_request(config).pack(flags=CheckFlag.COUNT)
    bits, east = config.coordinate_bits, config.map_size - 1
    rows = [y << bits | (y % 8) << 2 * bits for y in range(config.map_size)]
    return [(Command.CHECK, count + pack_paths(config, [[row, row | east]])) for row in rows]


@functools.cache
def fault_free(chip):
    """Return the answers of a chip after its reset to :func:`valid_requests`."""
    return CommandFuzz(chip, 0).session()


def fuzz(chip, seed, frames, *, board=False):
    """Send random frames to a chip after its reset; return the counts by kind and status."""
    if not board:
        one = CommandFuzz(chip, seed)
        one.run(frames)
        return one.counts
    with start_simulated(board_url("sim", CHIPS[chip])) as simulated:
        with simulated.open(timeout=30) as port:
            one = CommandFuzz(chip, seed, port)
            one.run(frames)
            port.timeout = 0.1
            assert port.read() == b""
            return one.counts


def main():
    """Exchange random frames as specified by the arguments, and count them by kind and status."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.support.gateware.command_fuzz", description=__doc__
    )
    parser.add_argument("chip", choices=CHIPS)
    parser.add_argument("seed", type=int)
    parser.add_argument("frames", type=int)
    parser.add_argument("--board", action="store_true", help="a simulated board, too")
    arguments = parser.parse_args()
    print(table(fuzz(arguments.chip, arguments.seed, arguments.frames, board=arguments.board)))


def table(counts):
    """Return counts by kind and status as lines of text."""
    lines = []
    for kind in (*KINDS, None):
        told = collections.Counter()
        for (drawn, status), count in counts.items():
            if kind in (drawn, None):
                told["silent" if status is None else status.name] += count
        parts = ", ".join(f"{name} {count}" for name, count in told.most_common())
        lines.append(f"{kind or 'all'}: {told.total()} frames; {parts}")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
