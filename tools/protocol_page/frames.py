"""Golden frames: recorded exchanges with the software models of four chips."""

from __future__ import annotations

import dataclasses
from typing import Any
from urllib.parse import urlencode

import numpy as np

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, VERSION, decode_frame, encode_frame
from pathgene.hdl.protocol.codes import CheckFlag, Command, LinkMode, Status
from pathgene.hdl.protocol.messages import (
    check_paths_request,
    check_request,
    generate_request,
    map_request,
    read_request,
    results_request,
    start_request,
    write_request,
)
from pathgene.hdl.protocol.paths import pack_cells, pack_paths
from pathgene.hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    POSITION_FRACTION,
    SCALE_FRACTION,
    NoFlyShape,
    ProblemRecord,
)
from pathgene.hdl.protocol.runs import RunOptions, guide_request
from pathgene.host.device.chip_map import coded_frames
from pathgene.sim.model.chip import Chip
from tools import chips
from tools.protocol_page.segments import split_reply, split_request, values_of


#: The chip of the URL ``sim:`` without options.
DEFAULT = Config(clocks_per_bit=4)
#: A chip with messages short enough to read.
SMALL = chips.SMALL.replace(checker=CheckerBuild.PARALLEL, lanes=4)
#: A chip that only checks paths.
CHECK_ONLY = SMALL.replace(core="none")
#: A chip that plans on its own.
PLANNER = SMALL.replace(core="planner")
#: Fields of COUNTERS that the model only predicts to within a few cycles per command.
TIMED = ("clocks", "receive", "transmit")


class Recorder:
    """Host of one model that records every exchange.

    Parameters
    ----------
    config : Config
    """

    def __init__(self, config: Config) -> None:
        self.config = config
        self.exchanges: list[dict[str, Any]] = []
        self._chip = Chip(config)
        self._session = 0
        self._next = 0

    def say(
        self,
        name: str,
        about: str,
        command: int,
        payload: bytes = b"",
        *,
        session: int | None = None,
        sequence: int | None = None,
        plain: bool = False,
    ) -> None:
        """Send one request; ``session`` and ``sequence`` default to the next command's."""
        session = self._session if session is None else session
        number = self._next if sequence is None else sequence
        body = bytes((session, number, command)) + payload
        reply = self._send(name, about, body, encode_frame(body, plain=plain))
        if command == Command.OPEN and reply[2] == Status.OK and session != self._session:
            self._session, self._next = session, 0
        elif sequence is None and not plain and command != Command.OPEN:
            self._next = (self._next + (reply[2] == Status.OK)) % 256

    def garble(self, name: str, about: str, frame: bytes) -> None:
        """Send bytes without a valid frame."""
        assert not self._chip.feed(frame)
        self.exchanges.append(
            {"name": name, "about": about, "request": {"frame": frame.hex()}, "reply": None}
        )

    def _send(self, name: str, about: str, body: bytes, frame: bytes) -> bytes:
        plain = decode_frame(frame[:-1])[1]
        answer = self._chip.feed(frame)
        answer_body = decode_frame(answer[:-1])[0] if answer else None
        request = self._request(body, frame, plain)
        exchange: dict[str, Any] = {"name": name, "about": about, "request": request, "reply": None}
        if answer_body is not None:
            exchange["reply"] = self._reply(body, answer_body, answer, plain)
        self.exchanges.append(exchange)
        return answer_body or b"\0\0\xff"

    def _request(self, body: bytes, frame: bytes, plain: bool) -> dict[str, Any]:
        code = body[2]
        said = _header(body, frame, plain) | {"code": code}
        if code not in list(Command):
            return said
        command, payload = Command(code), body[BODY_HEADER_BYTES:]
        said["command"] = command.name
        if command in (Command.STATUS, Command.CLEAR) and payload:
            return said  # The length is wrong.
        return said | values_of(split_request(self.config, command, payload))

    def _reply(
        self, request: bytes, body: bytes, frame: bytes, plain: bool
    ) -> dict[str, Any] | None:
        status = Status(body[2])
        said = _header(body, frame, plain) | {"code": body[2], "status": status.name}
        if status is not Status.OK:
            return said
        command = Command(request[2])
        segments = split_reply(
            self.config, command, request[BODY_HEADER_BYTES:], body[BODY_HEADER_BYTES:]
        )
        return said | values_of(segments)


def _header(body: bytes, frame: bytes, plain: bool) -> dict[str, Any]:
    return {
        "frame": frame.hex(),
        "body": body.hex(),
        "plain": plain,
        "session": body[0],
        "sequence": body[1],
    }


def golden_frames() -> dict[str, Any]:
    """Return the content of ``docs/protocol_frames.json``."""
    chips = {
        "small": (SMALL, _tour),
        "default": (DEFAULT, _short_tour),
        "check-only": (CHECK_ONLY, _without_core),
        "planner": (PLANNER, _runs),
    }
    told = []
    for name, (config, drive) in chips.items():
        recorder = Recorder(config)
        drive(recorder)
        told.append(
            {
                "name": name,
                "board": _board_url(config),
                "config": dataclasses.asdict(config),
                "exchanges": recorder.exchanges,
            }
        )
    return {"protocol_version": VERSION, "timed": list(TIMED), "chips": told}


def _board_url(config: Config) -> str:
    changes = {
        name: int(value) if isinstance(value, bool) else value
        for name, value in dataclasses.asdict(config).items()
        if value != getattr(DEFAULT, name)
    }
    return f"sim:?{urlencode(changes)}" if changes else "sim:"


def _pack(config: Config, *waypoints: tuple[int, int, int]) -> list[int]:
    bits = config.coordinate_bits
    return [x | y << bits | altitude << 2 * bits for x, y, altitude in waypoints]


def _tour(host: Recorder) -> None:
    """Record every command, every status and every way to lose a frame, on the small chip."""
    config = host.config
    open_session(host)
    paths = [
        _pack(config, *((3 + i + step, 2 + i * step % 7, 3 + step) for step in range(2 + i % 3)))
        for i in range(config.population)
    ]
    _flatten(host)
    wall = [0, 0, 6, 0, 0, 9, 15, 0, 0, 6, 0, 0]
    rectangle = map_request(config).pack(x=6, y=4, width=4, height=3)
    host.say(
        "MAP",
        "three rows of four cells; one of them is blocked",
        Command.MAP,
        rectangle + pack_cells(config, wall),
    )
    start = start_request(config).pack(
        seed=0x0123456789ABCDEF, x=15, y=15, altitude=14, avoid_ground=0
    )
    host.say("START", "generation 0 of a seed", Command.START, start)
    first = write_request(config).pack(slot=0)
    host.say("WRITE", "all slots", Command.WRITE, first + pack_paths(config, paths))
    two = read_request(config).pack(slot=2, count=2)
    host.say("READ", "slots 2 and 3", Command.READ, two)
    _generations(host)
    _checks(host)
    _errors(host)


def open_session(host: Recorder) -> None:
    """Request the chip's session, and open the next."""
    host.say("INFO", "plain; sequence 5 is the host's own", Command.INFO, sequence=5, plain=True)
    host.say("OPEN", "the session after the chip's, 0", Command.OPEN, session=1, sequence=255)


def _flatten(host: Recorder) -> None:
    edge = host.config.map_size
    whole = map_request(host.config).pack(x=0, y=0, width=edge, height=edge)
    flat = pack_cells(host.config, [0] * edge**2)
    host.say("MAP whole", "flat ground everywhere", Command.MAP, whole + flat)


def _ranked(config: Config, mode: LinkMode, order: list[int]) -> bytes:
    slots = {f"slot_{rank}": slot for rank, slot in enumerate(order)}
    return generate_request(config, mode).pack(mode=mode, **slots)


def _generations(host: Recorder) -> None:
    config = host.config
    order = [3, 0, 7, 1, 6, 2, 5, 4]
    rank = _ranked(config, LinkMode.RANK, order)
    recipe = _ranked(config, LinkMode.RECIPE, order)
    host.say("GENERATE rank", "the order of the slots, best first", Command.GENERATE, rank)
    latest = host.exchanges[-1]["request"]["sequence"]
    host.say(
        "repeated",
        "the same frame again: not executed again, answered again",
        Command.GENERATE,
        rank,
        sequence=latest,
    )
    host.say(
        "repeated in another mode",
        "the same command again, in the mode with the short reply",
        Command.GENERATE,
        recipe,
        sequence=latest,
    )
    host.say("GENERATE recipe", "the reply says how to rebuild", Command.GENERATE, recipe)
    population = generate_request(config, LinkMode.POPULATION).pack(mode=LinkMode.POPULATION)
    host.say(
        "GENERATE population",
        "slot 0 holds the best path already, slot 7 the worst",
        Command.GENERATE,
        population,
    )


def _checks(host: Recorder) -> None:
    config = host.config
    path = _pack(config, (2, 5, 7), (12, 5, 7))
    above = _pack(config, (2, 5, 14), (7, 12, 14), (12, 5, 12))
    through = _pack(config, (2, 5, 5), (8, 5, 9), (12, 5, 3))
    for name, about, flags, points in (
        ("CHECK", "up to the first hit", CheckFlag(0), path),
        ("CHECK counting", "every colliding cell of each segment", CheckFlag.COUNT, through),
        ("CHECK free", "a path that clears the wall", CheckFlag(0), above),
        ("CHECK brief", "totals only", CheckFlag.COUNT | CheckFlag.BRIEF, path),
    ):
        payload = check_request(config).pack(flags=flags) + pack_paths(config, [points])
        host.say(name, about, Command.CHECK, payload)
    start, goal = path
    three = check_paths_request(config).pack(
        slot=1, count=3, flags=CheckFlag.COUNT, start=start, goal=goal
    )
    host.say("CHECK_PATHS", "slots 1 to 3, counting", Command.CHECK_PATHS, three)
    first = results_request(config).pack(path=0, count=1)
    host.say("RESULTS", "the first of the three paths once more", Command.RESULTS, first)


def _errors(host: Recorder) -> None:
    config = host.config
    beyond = read_request(config).pack(slot=7, count=2)
    host.say("BAD_VALUE", "READ past the last slot", Command.READ, beyond)
    host.say("BAD_LENGTH", "STATUS has no payload", Command.STATUS, b"\0")
    host.say("UNKNOWN_COMMAND", "no command has this code", 200)
    expected = host.exchanges[-1]["request"]["sequence"]
    host.say(
        "OUT_OF_ORDER",
        "two numbers too far; the reply's sequence is the expected one",
        Command.STATUS,
        sequence=expected + 2,
    )
    host.say(
        "DUPLICATE", "a number executed before the latest", Command.STATUS, sequence=expected - 2
    )
    host.say("NO_SESSION", "a command of an earlier session", Command.STATUS, session=0)
    host.say("OPEN refused", "neither the open session nor the next", Command.OPEN, session=3)
    host.say("OPEN repeated", "the open session: nothing changes", Command.OPEN, session=1)
    host.say("plain frame", "a plain frame whose command is not INFO", Command.STATUS, plain=True)
    frame = bytearray(encode_frame(bytes((1, expected, Command.STATUS))))
    frame[3] ^= 0x40
    host.garble("bad CRC", "a damaged STATUS: dropped without a reply", bytes(frame))
    host.garble(
        "too short", "five bytes; the minimum is seven", bytes.fromhex("06 07 07 07 07 07 00")
    )
    host.garble("cut block", "a delimiter inside a block", bytes.fromhex("09 01 02 03 00"))
    host.say("STATUS", "the sticky errors tell what has been dropped and refused", Command.STATUS)
    host.say("CLEAR", "forget the sticky errors", Command.CLEAR)
    host.say("STATUS cleared", "no error since CLEAR", Command.STATUS)
    host.say("COUNTERS", "since reset", Command.COUNTERS)


def _short_tour(host: Recorder) -> None:
    """Record waypoints of a chip whose widths are not multiples of four."""
    config = host.config
    open_session(host)
    start = start_request(config).pack(seed=1, x=511, y=511, altitude=4094, avoid_ground=1)
    host.say("START", "new waypoints keep off the ground", Command.START, start)
    first = write_request(config).pack(slot=30)
    paths = [
        _pack(config, (1, 2, 3), (511, 0, 4094)),
        _pack(config, (300, 301, 302), (0, 511, 0), (7, 77, 777)),
    ]
    host.say("WRITE", "the last two slots", Command.WRITE, first + pack_paths(config, paths))
    two = read_request(config).pack(slot=30, count=2)
    host.say("READ", "the same two slots", Command.READ, two)
    cells = pack_cells(config, [1, 2, 4095, 4094, 0x123])
    row = map_request(config).pack(x=507, y=511, width=5, height=1)
    host.say("MAP", "five cells of 12 bits are 7.5 bytes, sent as 8", Command.MAP, row + cells)


def _without_core(host: Recorder) -> None:
    """Record a chip that rejects the commands of the genetic core."""
    config = host.config
    open_session(host)
    start = start_request(config).pack(seed=1, x=15, y=15, altitude=14, avoid_ground=0)
    host.say("START", "unknown without a genetic core", Command.START, start)
    _flatten(host)
    points = pack_paths(config, [_pack(config, (2, 5, 7), (12, 5, 7))])
    check = check_request(config).pack(flags=0) + points
    host.say("CHECK", "a path over flat ground", Command.CHECK, check)


def _runs(host: Recorder) -> None:
    """Record a run, a shape that appears on the path, and a warm run from farther along it."""
    config = host.config
    open_session(host)
    host.say("RUN refused", "there is no problem yet", Command.RUN, _options().pack(config))
    _flatten(host)
    wall = map_request(config).pack(x=7, y=0, width=1, height=10)
    host.say("MAP", "a wall that is high in the south", Command.MAP,
             wall + pack_cells(config, [12] * 6 + [9] * 4))  # fmt: skip
    host.say("PROBLEM", "from the west to the east", Command.PROBLEM, _problem(2).pack(config))
    host.say("BEST before", "no path before the first run", Command.BEST)
    host.say("RUN", "two islands of 16 seeds, 12 generations", Command.RUN,
             _options().pack(config))  # fmt: skip
    host.say("STATUS", "the run is over", Command.STATUS)
    host.say("BEST", "the best paths of different keys", Command.BEST)
    disc = NoFlyShape(
        first_x=9, first_y=4, last_x=13, last_y=8, edges=((-4, 4, 4),), bend_x=1, bend_y=1
    )
    host.say("BLOCK", "a disc of radius 2 around the corner (11, 6)", Command.BLOCK,
             disc.pack(config))  # fmt: skip
    host.say("PROBLEM moved", "the aircraft has flown a cell ahead", Command.PROBLEM,
             _problem(3).pack(config))  # fmt: skip
    host.say("RUN warm", "from the previous population and one new island of seeds",
             Command.RUN, _options(warm=True, slopes=(3,)).pack(config))  # fmt: skip
    host.say("STATUS warm", "cycles and generations of the latest run", Command.STATUS)
    host.say("BEST warm", "around the disc", Command.BEST)
    guide = guide_request(config)
    host.say("GUIDE", "north-west of the disc", Command.GUIDE,
             guide.pack(index=0, x=8, y=9, altitude=8))  # fmt: skip
    host.say("GUIDE last", "north-east of it", Command.GUIDE,
             guide.pack(index=1, x=12, y=9, altitude=9))  # fmt: skip
    host.say("RUN guided", "one island along the guide", Command.RUN,
             _options(slopes=(3,), guided=2).pack(config))  # fmt: skip
    host.say("BEST guided", "from the guide", Command.BEST)
    hill = np.array([[0, 1, 1, 1], [1, 3, 3, 2], [1, 3, 15, 2]])
    [(coded, _)] = coded_frames(config, hill, 2, 1)
    host.say("CODED_MAP", "a hill of 4 x 3 corners, one of them blocked", Command.CODED_MAP, coded)
    host.say("STOP", "without a run, nothing happens", Command.STOP)
    host.say("START", "unknown to a chip with the planner core", Command.START, bytes(15))
    host.say("COUNTERS", "since reset", Command.COUNTERS)


def _options(
    *, warm: bool = False, slopes: tuple[int, ...] = (3, 0), guided: int = 0
) -> RunOptions:
    return RunOptions(
        seed=5, cycles=100_000, generations=12, until_feasible=warm, seeds=16, slopes=slopes,
        warm=warm, guided=guided,
    )  # fmt: skip


def _problem(start_x: int) -> ProblemRecord:
    """Return a problem on the small map, with altitude steps of a quarter of a cell."""
    return ProblemRecord(
        start_x=start_x << POSITION_FRACTION,
        start_y=6 << POSITION_FRACTION,
        start_altitude=7 << ALTITUDE_FRACTION,
        goal_x=14 << POSITION_FRACTION,
        goal_y=5 << POSITION_FRACTION,
        goal_altitude=7 << ALTITUDE_FRACTION,
        x_limit=15,
        y_limit=15,
        altitude_limit=14,
        x_scale=1 << SCALE_FRACTION,
        y_scale=1 << SCALE_FRACTION,
        rise=4 << 16,
        climb=400,
        descent=600,
        radius=100,
        base=-64,
        drag=5_201,
        fuel=60_294,
        fuel_shift=13,
        key_shift=4,
        block_shift=0,
    )
