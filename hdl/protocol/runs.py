"""A run of the planner core: its options, its outcome, and their form on the link."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.layout import Field, Layout, numbered, sized
from pathgene.hdl.protocol.paths import pack_paths, unpack_paths
from pathgene.hdl.protocol.planner import MEMO_ROWS, VALUE_BITS, PathClass
from pathgene.hdl.protocol.random_words import SEED_BITS


__all__ = [
    "ISLANDS",
    "LIFTS",
    "RETURNED",
    "SLOPE_BITS",
    "WARM_SLOPES",
    "Outcome",
    "Population",
    "RunOptions",
    "guide_request",
    "pack_best",
    "run_request",
    "unpack_best",
]

#: Corners and altitude steps of the waypoints of paths.
Population = Sequence[Sequence[tuple[int, int, int]]]
#: Maximum number of populations of a run before they become one.
ISLANDS = 2
#: Maximum passes that raise the first paths of an island.
LIFTS = 4
#: Maximum paths that a run returns.
RETURNED = 8
#: Width of the slope of a surface.
SLOPE_BITS = 4
#: Slope for the island of fresh seeds alongside the population of a warm start.
WARM_SLOPES = (0,)
#: Bytes of a key on the link.
_KEY_BYTES = 4


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Options of a run.

    Parameters
    ----------
    seed : int
        0..2**64 - 1. It determines all random draws.
    cycles, generations : int
        The run stops breeding once it reaches either number, over all islands together. The first
        populations are always completed.
    until_feasible : bool
        Once there is one population, the limit on generations only ends the run if its best path is
        feasible.
    give_up_rank : int
        While the best path is feasible, a child is only walked if it is cheaper than the path of
        this rank.
    slopes : tuple of int
        One island for each, bred one after another: at most two, or at most one on a warm start, in
        addition to the earlier population. The island's route is found on the minimum ground of the
        blocks, raised until no slope exceeds this number, 1..15, times half the climb limit; 0
        leaves the ground unchanged.
    seeds : int
        Number of paths seeded along each route; the best become the island's population.
    lifts : int
        Passes that raise each waypoint of an island's first population out of the ground, 0..4.
    share : int
        Share of the time after the first populations for all islands together, in sixteenths.
    warm : bool
        Continue from the population of the previous run.
    guided : int
        Number of waypoints of the guide: the paths of the first seeded island have its waypoints,
        raised by random heights, and no route is found for that island. 0: no guide; otherwise 2 to
        the longest path, and at least one slope.
    paths : int
        Maximum paths returned, 1..8.
    memo : int
        Rows of the memo of segments: 0, or a power of two. It is fixed in a chip and only affects
        the cycles.
    """

    seed: int = 0
    cycles: int = 1_000_000
    generations: int = (1 << 32) - 1
    until_feasible: bool = False
    give_up_rank: int = 7
    slopes: tuple[int, ...] = (3, 0)
    seeds: int = 128
    lifts: int = 2
    share: int = 8
    warm: bool = False
    guided: int = 0
    paths: int = RETURNED
    memo: int = MEMO_ROWS

    def check(self, config: Config) -> None:
        """Raise an error unless a chip of ``config`` can run this.

        Raises
        ------
        ValueError
            If a value is outside its range.
        """
        counts = "at most one on a warm start" if self.warm else "one or two"
        for name, rule, holds in (
            ("seed", "from 0 to 2**64 - 1", 0 <= self.seed < 1 << SEED_BITS),
            ("cycles", "from 0 to 2**32 - 1", 0 <= self.cycles < 1 << 32),
            ("generations", "from 0 to 2**32 - 1", 0 <= self.generations < 1 << 32),
            ("give_up_rank", "a rank", 0 <= self.give_up_rank < config.population),
            ("slopes", counts, 1 <= len(self.slopes) + self.warm <= ISLANDS),
            (
                "slopes",
                f"from 0 to {(1 << SLOPE_BITS) - 1}",
                all(0 <= slope < 1 << SLOPE_BITS for slope in self.slopes),
            ),
            ("seeds", "from the population to 65535", config.population <= self.seeds < 1 << 16),
            ("lifts", f"from 0 to {LIFTS}", 0 <= self.lifts <= LIFTS),
            ("share", "from 0 to 16", 0 <= self.share <= 16),
            (
                "guided",
                f"0, or from {config.MIN_WAYPOINTS} to {config.max_waypoints} with an island",
                self.guided == 0
                or (config.MIN_WAYPOINTS <= self.guided <= config.max_waypoints and self.slopes),
            ),
            ("paths", f"from 1 to {RETURNED}", 1 <= self.paths <= RETURNED),
            (
                "memo",
                "0, or a power of two up to 65536",
                0 <= self.memo <= 1 << 16 and self.memo & self.memo - 1 == 0 and self.memo != 1,
            ),
        ):
            if not holds:
                raise ValueError(f"RunOptions.{name} must be {rule}, not {getattr(self, name)!r}")

    def pack(self, config: Config) -> bytes:
        """Return the payload of a RUN, :func:`run_request`.

        Raises
        ------
        ValueError
            If a value is outside its range.
        """
        self.check(config)
        values = {
            name: int(getattr(self, name))
            for name, _ in run_request(config).fields
            if hasattr(self, name)
        }
        for i in range(ISLANDS):
            values[f"slope_{i}"] = self.slopes[i] if i < len(self.slopes) else 0
        return run_request(config).pack(**values, islands=len(self.slopes))

    @classmethod
    def unpack(cls, config: Config, payload: bytes) -> RunOptions:
        """Return the options in the payload of a RUN, the inverse of :meth:`pack`.

        Raises
        ------
        ValueError
            If the payload has the wrong size, or a value is outside its range.
        """
        values = run_request(config).unpack(payload)
        count = values.pop("islands")
        slopes = tuple(values.pop(f"slope_{i}") for i in range(ISLANDS))
        if count > ISLANDS:
            raise ValueError(f"RunOptions.slopes must be at most {ISLANDS}, not {count}")
        flags = {name: bool(values.pop(name)) for name in ("until_feasible", "warm")}
        options = cls(**values, **flags, slopes=slopes[:count])
        options.check(config)
        return options


@dataclass(frozen=True)
class Outcome:
    """Result of a run.

    Attributes
    ----------
    paths : list of list of (int, int, int)
        Paths with distinct keys, at most the number in the options, best first: corners and steps
        of their waypoints, without start and goal.
    keys : list of int
        Their keys.
    population : list of list of (int, int, int)
        All paths at the end, best first: the population for a warm run.
    generations : int
        Generations bred, on all islands together.
    cycles : int
        Cycles of the run.
    breed, score, walk, sort, wavefront : int
        Cycles in which children were planned; points scored; segments and chords walked; a
        population collected and sorted; blocks scanned, costs spread and routes found. These
        overlap.
    """

    paths: list[list[tuple[int, int, int]]]
    keys: list[int]
    population: list[list[tuple[int, int, int]]]
    generations: int = 0
    cycles: int = 0
    breed: int = 0
    score: int = 0
    walk: int = 0
    sort: int = 0
    wavefront: int = 0

    @property
    def classes(self) -> list[PathClass]:
        """Classes of the paths."""
        return [PathClass(key >> VALUE_BITS) for key in self.keys]


@functools.lru_cache
def run_request(config: Config) -> Layout:
    """Return the fields of a RUN: :class:`RunOptions` without ``memo``, which is built in.

    ``islands`` is the number of slopes; later slopes are ignored.
    """
    return Layout(
        (
            Field("seed", SEED_BITS, "any", "Seed of the random source"),
            Field("cycles", 32, "any", "The run ends with the generation that reaches them"),
            Field("generations", 32, "any", "The run ends after as many, all islands together"),
            Field(
                "give_up_rank",
                8,
                "0 … population − 1",
                "A child not cheaper than this rank is not walked",
            ),
            Field("seeds", 16, "population or more", "Paths seeded along each route"),
            Field("lifts", 3, "0 … 4", "Passes that raise a first population out of the ground"),
            Field("share", 5, "0 … 16", "Time of both islands together, in sixteenths"),
            Field("warm", 1, "0, 1", "1: the previous population is the first island"),
            Field("islands", 2, "1, 2; 0, 1 if warm", "Islands of fresh seeds"),
            Field(
                "guided",
                8,
                "0, 2 … max_waypoints",
                "Waypoints of the guide that the first of these islands follows; 0: none",
            ),
            Field("until_feasible", 1, "0, 1", "1: the generations wait for a feasible path"),
            *numbered(
                "slope",
                ISLANDS,
                SLOPE_BITS,
                "0 … 15",
                "Steepest slope of each island, in halves of the climb limit; 0: any",
            ),
            Field("paths", 4, "1 … 8", "Maximum number of paths that BEST returns"),
        )
    )


@functools.lru_cache
def guide_request(config: Config) -> Layout:
    """Return the place in the guide, and its waypoint, which the limits of the problem clamp."""
    return Layout(
        (
            Field("index", 8, "0 … max_waypoints − 1", "Place of the waypoint in the guide"),
            sized(config, "x", "coordinate_bits", "any", "Its corner"),
            sized(config, "y", "coordinate_bits", "any", "The same northwards"),
            sized(config, "altitude", "altitude_bits", "any", "Its step"),
        )
    )


def pack_best(config: Config, paths: Sequence[Sequence[int]], keys: Sequence[int]) -> bytes:
    """Return the reply to a BEST: each path's key in 32 bits, then its packed waypoints."""
    parts = []
    for path, key in zip(paths, keys, strict=True):
        parts += [key.to_bytes(_KEY_BYTES, "little"), pack_paths(config, [path])]
    return b"".join(parts)


def unpack_best(config: Config, payload: bytes) -> tuple[list[list[int]], list[int]]:
    """Return packed paths and keys, the inverse of :func:`pack_best`.

    Raises
    ------
    ValueError
        If the payload ends inside a key or a path, or the length of a path is out of range.
    """
    paths: list[list[int]] = []
    keys, at = [], 0
    size, bits = config.waypoint_bytes, config.waypoint_bits
    while at < len(payload):
        keys.append(int.from_bytes(payload[at : at + _KEY_BYTES], "little"))
        first = at = at + _KEY_BYTES
        while at + size <= len(payload):
            at += size
            if int.from_bytes(payload[at - size : at], "little") >> bits & 1:
                break
        if first == at:
            raise ValueError("Best paths must have waypoints behind each key")
        paths += unpack_paths(config, payload[first:at])
    return paths, keys
