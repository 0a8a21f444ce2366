"""Populations bred by the model of the chip, and the bytes on its line."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import random
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.protocol import (
    BODY_HEADER_BYTES,
    CheckFlag,
    Command,
    LinkMode,
    Status,
    check_paths_request,
    check_request,
    generate_request,
    map_request,
    pack_cells,
    pack_paths,
    read_request,
    results_request,
    start_request,
    write_request,
)
from pathgene.hdl.protocol.codec import encode_frame
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link
from pathgene.sim.model.chip import Chip as ChipModel
from pathgene.sim.model.port import ModelPort
from tools.recording.random_inputs import checksum, ground, point, population, shuffled, waypoint


__all__ = ["GENERATIONS", "record_frames", "record_generations"]

#: Generations per run.
GENERATIONS = 50
_SEEDS = (1, 2, 3)
#: All paths are checked after every generation whose number is a multiple of this.
_CHECK_EVERY = 5
#: The model replies at once; the limit only ensures that a busy machine repeats no frame.
_TIMEOUT_S = 60.0

_DEFAULT = Config()
_SMALL = Config(
    population=8,
    children=4,
    elites=1,
    survivors=3,
    perturbs=1,
    inserts=1,
    deletes=1,
    max_waypoints=5,
    map_size=16,
    coarse_factor=4,
    altitude_bits=6,
)
#: Configurations, with a flag for new waypoints that avoid the ground.
_CHIPS = {
    "default": (_DEFAULT, False),
    "with map": (_DEFAULT, True),
    "two-tier with map": (_DEFAULT.replace(checker=CheckerBuild.TWO_TIER, lanes=1), True),
    "without checker": (
        _DEFAULT.replace(checker=CheckerBuild.NONE, survivor_selection="rank"),
        False,
    ),
    "small with map": (_SMALL, True),
}


class _TappedPort(ModelPort):
    """A port of the model that keeps a digest of the bytes in each direction.

    SHA-256 instead of CRC-32: a frame ends with its own CRC-32, so a CRC-32 over whole frames does
    not depend on their contents.
    """

    def __init__(self, chip: ChipModel) -> None:
        super().__init__(chip)
        self.sent, self.received = hashlib.sha256(), hashlib.sha256()

    def write(self, data: bytes | bytearray | memoryview) -> int:
        self.sent.update(data)
        return super().write(data)

    def read(self, size: int = 1) -> bytes:
        data = super().read(size)
        self.received.update(data)
        return data


def record_generations(
    seeds: tuple[int, ...] = _SEEDS, chips: tuple[str, ...] = tuple(_CHIPS)
) -> dict[str, Any]:
    """Return the record of :func:`_generations` by chip, link mode and seed."""
    return {
        f"{name}, {mode.name.lower()}, seed {seed}": _generations(*_CHIPS[name], mode, seed)
        for name in chips
        for mode in LinkMode
        for seed in seeds
    }


@functools.cache
def _heights(config: Config) -> NDArray[np.int64]:
    # Enough peaks and blocked cells that new waypoints are redrawn and given up.
    return ground(config, seed=4, peaks=0.2, blocked=0.1)


def _generations(config: Config, avoid_ground: bool, mode: LinkMode, seed: int) -> dict[str, Any]:
    """Breed on the model over a link, with a random ranking for each generation.

    ``populations`` are the CRC-32 of each generation's population as the chip sends it, which is
    also the host's copy; ``checks`` the CRC-32 of all results of a check of the whole population;
    ``sent`` and ``received`` the SHA-256 of all bytes on the line.
    """
    rng = random.Random(seed)
    port = _TappedPort(ChipModel(config))
    with Chip(Link(port, timeout_s=_TIMEOUT_S)) as chip:
        if avoid_ground:
            chip.upload_map(_heights(config))
        highest = config.map_size - 1
        limits = (highest, highest, config.blocked_altitude - 1)
        chip.start(seed, limits, avoid_ground=avoid_ground)
        chip.load(population(rng, config))
        populations, checks = [], []
        for generation in range(1, GENERATIONS + 1):
            chip.step(shuffled(rng, config.population), mode)
            paths = chip.paths
            if paths != chip.read(0, config.population):
                raise AssertionError(f"The host's copy is wrong in generation {generation}")
            populations.append(zlib.crc32(pack_paths(config, paths)))
            if avoid_ground and generation % _CHECK_EVERY == 0:
                ends = (waypoint(config, point(rng, config)) for _ in range(2))
                counting = generation % (2 * _CHECK_EVERY) == 0
                checked = chip.check_population(*ends, counting=counting)
                checks.append(checksum(dataclasses.astuple(checked)))
        counters = chip.counters()
    return {
        "populations": populations,
        "checks": checks,
        "sent": port.sent.hexdigest(),
        "received": port.received.hexdigest(),
        "counters": counters,
    }


class _Conversation:
    """Frames to a model and its replies, under descriptive names."""

    def __init__(self, config: Config) -> None:
        self.frames: dict[str, dict[str, str]] = {}
        self.session = self.sequence = 0
        self._chip = ChipModel(config)

    def ask(self, name: str, code: int, payload: bytes = b"", *, plain: bool = False) -> None:
        """Send a command with the next sequence number."""
        body = bytes((self.session, self.sequence, code)) + payload
        self.send(name, encode_frame(body, plain=plain))
        if code not in (Command.INFO, Command.OPEN):
            self.sequence = (self.sequence + 1) % 256

    def refused(self, name: str, code: int, payload: bytes = b"", **header: int) -> None:
        """Send a command that is not executed, with these changes of the header."""
        session = header.get("session", self.session)
        sequence = (self.sequence + header.get("ahead", 0)) % 256
        self.send(name, encode_frame(bytes((session, sequence, code)) + payload))

    def send(self, name: str, frame: bytes) -> None:
        """Send these bytes."""
        self.frames[name] = {"request": frame.hex(), "reply": self._chip.feed(frame).hex()}


def record_frames() -> dict[str, Any]:
    """Return the bytes of request and reply, as hex, of every kind of exchange."""
    return {"small": _frames(_SMALL), "default": _frames(_DEFAULT)}


def _frames(config: Config) -> dict[str, dict[str, str]]:
    rng = random.Random(5)
    talk = _Conversation(config)
    talk.ask("INFO", Command.INFO, plain=True)
    talk.refused("no session", Command.STATUS, session=7)
    talk.session = 1
    talk.ask("OPEN", Command.OPEN)
    talk.ask("STATUS", Command.STATUS)
    _breed(talk, config, rng)
    _check(talk, config, rng)
    talk.ask("COUNTERS", Command.COUNTERS)
    _refuse(talk, config)
    talk.ask("STATUS with errors", Command.STATUS)
    talk.ask("CLEAR", Command.CLEAR)
    talk.ask("STATUS without errors", Command.STATUS)
    return talk.frames


def _breed(talk: _Conversation, config: Config, rng: random.Random) -> None:
    highest = config.map_size - 1
    limits = {"x": highest, "y": highest - 1, "altitude": config.blocked_altitude - 2}
    start = start_request(config).pack(seed=0x0123456789ABCDEF, avoid_ground=1, **limits)
    talk.ask("START", Command.START, start)
    paths = population(rng, config)
    for number, first in enumerate(range(0, config.population, 2)):
        payload = write_request(config).pack(slot=first) + pack_paths(
            config, paths[first : first + 2]
        )
        talk.ask(f"WRITE {number}", Command.WRITE, payload)
    talk.ask("READ", Command.READ, read_request(config).pack(slot=1, count=2))
    for mode in LinkMode:
        layout = generate_request(config, mode)
        order = [] if mode is LinkMode.POPULATION else shuffled(rng, config.population)
        values = {f"slot_{rank}": slot for rank, slot in enumerate(order)}
        payload = layout.pack(mode=mode, **values)
        talk.ask(f"GENERATE {mode.name}", Command.GENERATE, payload)
    again = bytes((LinkMode.RECIPE, *range(config.population)))
    talk.sequence -= 1
    talk.ask("GENERATE repeated", Command.GENERATE, again)


def _check(talk: _Conversation, config: Config, rng: random.Random) -> None:
    side = 4
    cells = [config.blocked_altitude - 3 * number for number in range(side * side)]
    corner = map_request(config).pack(x=2, y=3, width=side, height=side)
    talk.ask("MAP", Command.MAP, corner + pack_cells(config, cells))
    # Cells that were never written are blocked.
    low = map_request(config).pack(x=8, y=8, width=8, height=8)
    talk.ask("MAP low", Command.MAP, low + pack_cells(config, [1] * 64))
    top = config.blocked_altitude - 1
    free = [waypoint(config, at) for at in ((8, 8, top), (15, 9, 2), (9, 15, top))]
    hits = [waypoint(config, at) for at in ((8, 8, top), (15, 9, 1), (2, 3, 0))]
    for name, path in (("free", free), ("colliding", hits)):
        for flags in (CheckFlag(0), CheckFlag.COUNT, CheckFlag.COUNT | CheckFlag.BRIEF):
            payload = check_request(config).pack(flags=flags) + pack_paths(config, [path])
            talk.ask(f"CHECK {name}, flags {int(flags)}", Command.CHECK, payload)
    talk.ask("RESULTS", Command.RESULTS, results_request(config).pack(path=0, count=1))
    ends = {"start": free[0], "goal": waypoint(config, point(rng, config))}
    payload = check_paths_request(config).pack(
        slot=0, count=config.population, flags=CheckFlag.COUNT, **ends
    )
    talk.ask("CHECK_PATHS", Command.CHECK_PATHS, payload)
    talk.ask("RESULTS of slots", Command.RESULTS, results_request(config).pack(path=1, count=2))


def _refuse(talk: _Conversation, config: Config) -> None:
    """Send every frame that is not executed: a status other than OK, or no reply."""
    talk.refused("unknown command", 0x7F)
    talk.refused("bad length", Command.START, b"\1")
    talk.refused("bad value", Command.READ, read_request(config).pack(slot=0, count=0))
    talk.refused("duplicate", Command.COUNTERS, ahead=-2)
    talk.refused("out of order", Command.COUNTERS, ahead=1)
    talk.refused("other session", Command.COUNTERS, session=talk.session + 1)
    damaged = bytearray(encode_frame(bytes((talk.session, talk.sequence, Command.CLEAR))))
    damaged[BODY_HEADER_BYTES] ^= 0x10
    talk.send("damaged", bytes(damaged))
    talk.send("malformed", bytes((9, Status.OK + 1, 0)))
