"""The one definition of what host and chip say to each other. Pure Python.

Frame
-----
``COBS(body | CRC-32) 0x00``. The body is at least 3 bytes: session, sequence, code, then a payload.
The CRC (IEEE 802.3, as in zlib; least significant byte first) has each byte XORed with
:data:`VERSION`, so that ends of different versions do not understand each other by accident. Frames
about :data:`Command.INFO` are *plain*: their CRC is not XORed and their layout never changes, so
that every host can ask any chip for its version.

Order
-----
A host opens the session after the chip's present one, modulo 256 (:data:`Command.OPEN`); this sets
the expected sequence number to 0. Opening the present session changes nothing, opening any other is
answered with :data:`Status.NO_SESSION`, so a frame from the past cannot do it. Every other command
but ``INFO`` carries the session and the next sequence number, modulo 256. The chip

- executes the command with the expected number, answers, and expects the next;
- answers the one before that again without executing it again (the answer was lost);
- answers :data:`Status.DUPLICATE` to the 126 before that one, :data:`Status.OUT_OF_ORDER` to
  others;
- answers :data:`Status.NO_SESSION` to another session, and nothing to a damaged frame.

A refused command (an error as status) is not counted as executed: its number stays the expected
one. A GENERATE that is answered again may ask for another :class:`LinkMode` than the first time, so
that a host can do with a short answer where long ones get damaged. A command is executed exactly
once and in order, whatever the line loses, damages, repeats or reorders. A host may have several
commands unanswered as long as their bodies with CRCs fit in
:attr:`hdl.config.Config.receive_buffer`; an answer confirms every command up to its own.

The answer has the command's session and sequence, a :class:`Status` as code, and the payload of the
reply; a status other than ``OK`` has none.

Payloads are fields of whole bits, least significant first, the first field lowest, padded with
zeros to bytes. Waypoints are ``waypoint_bytes`` each: x, y, altitude, then a bit that marks the
last of its path.
"""

from __future__ import annotations

import enum
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from hdl.config import Config, SurvivorSelection
from hdl.draws import SEED_BITS


__all__ = [
    "BODY_HEADER_BYTES",
    "CRC_BYTES",
    "DELIMITER",
    "VERSION",
    "ChipState",
    "Command",
    "Counter",
    "Layout",
    "LinkMode",
    "Status",
    "StickyError",
    "config_from_info",
    "counters_reply",
    "frame_crc",
    "generate_request",
    "info_reply",
    "info_values",
    "open_request",
    "pack_paths",
    "read_request",
    "recipe_reply",
    "start_request",
    "status_reply",
    "survivors_reply",
    "unpack_paths",
    "write_request",
]

#: Version of the protocol, 1..255; 0 stands for plain frames.
VERSION = 1
#: Ends every frame.
DELIMITER = 0x00
#: Session, sequence, code.
BODY_HEADER_BYTES = 3
CRC_BYTES = 4


class Command(enum.IntEnum):
    """Code of a request."""

    #: What the chip is: :func:`info_reply`. Plain, and needs no session.
    INFO = 1
    #: Open the session named in the header; the expected sequence number becomes 0.
    OPEN = 2
    #: State, generation, sticky errors: :func:`status_reply`.
    STATUS = 3
    #: Seed, limits, generation 0: :func:`start_request`.
    START = 4
    #: Paths into consecutive slots: :func:`write_request`, then the waypoints.
    WRITE = 5
    #: One generation: :func:`generate_request`; the reply depends on the :class:`LinkMode`.
    GENERATE = 6
    #: Paths of consecutive slots: :func:`read_request`; the reply is their waypoints.
    READ = 7
    #: Clocks and bytes since reset: :func:`counters_reply`.
    COUNTERS = 8
    #: Clear the sticky errors.
    CLEAR = 9


class Status(enum.IntEnum):
    """Code of an answer."""

    OK = 0
    #: Executed long ago; nothing was done, nothing is sent again.
    DUPLICATE = 1
    #: Not the next command; the sequence number in the answer is the expected one.
    OUT_OF_ORDER = 2
    #: Another session is open, or none.
    NO_SESSION = 3
    #: No such command.
    UNKNOWN_COMMAND = 4
    #: The payload is shorter or longer than the command's.
    BAD_LENGTH = 5
    #: A value is outside its range: slot, number of paths, waypoint count, order not a permutation.
    BAD_VALUE = 6


class LinkMode(enum.IntEnum):
    """What a generation's request and reply carry."""

    #: The population is sorted already; the reply is the whole new population.
    POPULATION = 0
    #: The request carries the order of the slots; the reply the survivors' slots and the children.
    RANK = 1
    #: As above; the reply says what was done (:func:`recipe_reply`), and no waypoint but new ones.
    RECIPE = 2


class ChipState(enum.IntEnum):
    """State of the control unit (*allaire-2008*, section 4.2)."""

    LISTEN = 0
    RECEIVE = 1
    CROSSOVER = 2
    MUTATE = 3
    UPDATE = 4
    TRANSMIT = 5


class StickyError(enum.IntFlag):
    """Errors the chip has seen since the last CLEAR."""

    #: A byte without a stop bit.
    FRAMING = 1
    #: A frame was dropped because the receive buffer was full.
    OVERRUN = 2
    #: A frame's CRC was wrong.
    CRC = 4
    #: A frame was too short, or its COBS code broken.
    MALFORMED = 8
    #: A command was answered with a status of BAD_LENGTH, BAD_VALUE or UNKNOWN_COMMAND.
    REFUSED = 16


class Counter(enum.StrEnum):
    """Counters of the chip since reset, in the order of :func:`counters_reply`."""

    #: Clocks.
    CLOCKS = "clocks"
    #: Clocks in which a frame was coming in or a command was being taken.
    RECEIVE = "receive"
    #: Clocks of each unit.
    CROSSOVER = "crossover"
    MUTATION = "mutation"
    UPDATE = "update"
    #: Clocks in which an answer was being made or was on the line.
    TRANSMIT = "transmit"
    #: Most clocks from the first of the crossover to the new population, of one generation.
    LONGEST = "longest"
    #: Generations executed.
    GENERATIONS = "generations"
    #: Mutations that a limit on the length forbade.
    REFUSED_MUTATIONS = "refused_mutations"
    #: Bytes on the line, both ways, delimiters and damaged frames included.
    BYTES_RECEIVED = "bytes_received"
    BYTES_SENT = "bytes_sent"


@dataclass(frozen=True)
class Layout:
    """Fields of a payload.

    Parameters
    ----------
    fields : tuple of (str, int)
        Name and width in bits of each, the lowest first.
    """

    fields: tuple[tuple[str, int], ...]

    @property
    def bits(self) -> int:
        """Width of all fields together."""
        return sum(width for _, width in self.fields)

    @property
    def size(self) -> int:
        """Bytes on the link."""
        return (self.bits + 7) // 8

    def pack(self, **values: int) -> bytes:
        """Return the payload with ``values``, one for each field.

        Raises
        ------
        ValueError
            If a field is missing, unknown, or does not fit.
        """
        names = [name for name, _ in self.fields]
        if sorted(values) != sorted(names):
            raise ValueError(f"Fields must be {names}, not {list(values)}")
        packed = shift = 0
        for name, width in self.fields:
            if not 0 <= values[name] < 1 << width:
                raise ValueError(f"{name} must fit in {width} bits, not {values[name]!r}")
            packed |= values[name] << shift
            shift += width
        return packed.to_bytes(self.size, "little")

    def unpack(self, payload: bytes) -> dict[str, int]:
        """Return the fields of ``payload``.

        Raises
        ------
        ValueError
            If its size is not :attr:`size`.
        """
        if len(payload) != self.size:
            raise ValueError(f"Payload must have {self.size} bytes, not {len(payload)}")
        packed = int.from_bytes(payload, "little")
        values = {}
        for name, width in self.fields:
            values[name] = packed & ((1 << width) - 1)
            packed >>= width
        return values


def _numbered(name: str, count: int, width: int) -> tuple[tuple[str, int], ...]:
    return tuple((f"{name}_{i}", width) for i in range(count))


def open_request(config: Config) -> Layout:
    """Nothing: the session is in the header."""
    return Layout(())


def start_request(config: Config) -> Layout:
    """Seed of the random source and highest values of new waypoints."""
    return Layout((("seed", SEED_BITS), ("x", 16), ("y", 16), ("altitude", 16)))


def write_request(config: Config) -> Layout:
    """First slot; the waypoints of one or more paths follow."""
    return Layout((("slot", 8),))


def read_request(config: Config) -> Layout:
    """First slot and number of slots, 1 or more."""
    return Layout((("slot", 8), ("count", 8)))


def generate_request(config: Config, mode: LinkMode) -> Layout:
    """Link mode; in the modes that need it, the slots from the best path to the worst."""
    order = () if mode is LinkMode.POPULATION else _numbered("slot", config.population, 8)
    return Layout((("mode", 8), *order))


def info_reply(config: Config) -> Layout:
    """Version and build first: these two never move. Then the configuration."""
    return Layout(
        (
            ("version", 8),
            ("build_id", 32),
            ("session", 8),
            ("population", 16),
            ("children", 8),
            ("elites", 8),
            ("survivors", 8),
            ("perturbs", 8),
            ("inserts", 8),
            ("deletes", 8),
            ("max_waypoints", 8),
            ("map_size", 16),
            ("coarse_factor", 16),
            ("altitude_bits", 8),
            ("box_percent", 8),
            ("rank_survivors", 8),
            ("clock_hz", 32),
            ("clocks_per_bit", 16),
            ("receive_buffer", 16),
        )
    )


def info_values(config: Config) -> dict[str, int]:
    """Return every field of :func:`info_reply` but the session, which the chip fills in."""
    fields = {name for name, _ in info_reply(config).fields}
    values = {name: getattr(config, name) for name in fields if hasattr(config, name)}
    return values | {
        "version": VERSION,
        "rank_survivors": int(config.survivor_selection is SurvivorSelection.RANK),
    }


def config_from_info(values: dict[str, int]) -> Config:
    """Return the configuration that :func:`info_reply`'s ``values`` describe."""
    names = set(values) - {"version", "build_id", "session", "rank_survivors"}
    survivors = SurvivorSelection.RANK if values["rank_survivors"] else SurvivorSelection.UNIFORM
    return Config(survivor_selection=survivors, **{name: values[name] for name in names})


def status_reply(config: Config) -> Layout:
    """State, the eight latest states (4 bits each, the latest lowest), errors and last clocks.

    ``crossover``, ``mutation`` and ``update`` are the clocks of the latest generation.
    """
    return Layout(
        (
            ("state", 8),
            ("history", 32),
            ("errors", 8),
            ("generation", 32),
            ("crossover", 16),
            ("mutation", 16),
            ("update", 16),
        )
    )


def counters_reply(config: Config) -> Layout:
    """Every :class:`Counter`, 48 bits each; taken at one instant, when the command is executed."""
    return Layout(tuple((counter.value, 48) for counter in Counter))


def survivors_reply(config: Config) -> Layout:
    """What stands before the children in :data:`LinkMode.RANK`: the survivors' former slots."""
    return Layout(_numbered("survivor", config.survivors, 8))


def recipe_reply(config: Config) -> Layout:
    """What a generation did, and the CRC-32 of the new population.

    ``parent`` and ``survivor`` are slots before the update. Of each mutator: whether it was
    applied, its child, and its waypoint's index; of each that makes one, the new waypoint.
    """
    mutations: list[tuple[str, int]] = []
    for i in range(config.mutators):
        mutations += [
            (f"applied_{i}", 1),
            (f"child_{i}", config.child_bits),
            (f"index_{i}", config.index_bits),
        ]
    return Layout(
        (
            *_numbered("parent", config.crossovers, config.slot_bits),
            *_numbered("survivor", config.survivors, config.slot_bits),
            *mutations,
            *_numbered("waypoint", config.patches, config.waypoint_bits),
            ("checksum", 32),
        )
    )


def pack_paths(config: Config, paths: Iterable[Sequence[int]]) -> bytes:
    """Return ``paths`` (packed waypoints each) as they go over the link."""
    size, last = config.waypoint_bytes, 1 << config.waypoint_bits
    parts = []
    for path in paths:
        parts += [waypoint.to_bytes(size, "little") for waypoint in path[:-1]]
        parts.append((path[-1] | last).to_bytes(size, "little"))
    return b"".join(parts)


def unpack_paths(config: Config, payload: bytes) -> list[list[int]]:
    """Return the paths in ``payload``, the inverse of :func:`pack_paths`.

    Raises
    ------
    ValueError
        If it ends inside a waypoint or a path, or a path is shorter or longer than a chromosome.
    """
    size, bits = config.waypoint_bytes, config.waypoint_bits
    if len(payload) % size:
        raise ValueError(f"Paths must be whole waypoints of {size} bytes, not {len(payload)} bytes")
    paths: list[list[int]] = []
    path: list[int] = []
    for at in range(0, len(payload), size):
        word = int.from_bytes(payload[at : at + size], "little")
        path.append(word & ((1 << bits) - 1))
        if word >> bits & 1:
            if not config.MIN_WAYPOINTS <= len(path) <= config.max_waypoints:
                raise ValueError(
                    f"Path must have {config.MIN_WAYPOINTS} to {config.max_waypoints} waypoints, "
                    f"not {len(path)}"
                )
            paths.append(path)
            path = []
    if path:
        raise ValueError("Paths must end with a waypoint marked last")
    return paths


def frame_crc(body: bytes, *, plain: bool) -> int:
    """Return the CRC that follows ``body`` in a frame."""
    # In every byte of the CRC: no single damaged byte turns a frame into a plain one.
    return zlib.crc32(body) ^ (0 if plain else VERSION * 0x01010101)
