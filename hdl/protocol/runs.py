"""A run of the planner on the chip: its options, its outcome, and both on the link."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hdl.config import Config
from hdl.protocol.layout import Layout, numbered
from hdl.protocol.paths import pack_paths, unpack_paths
from hdl.protocol.planner import VALUE_BITS, PathClass
from hdl.protocol.random_words import SEED_BITS


__all__ = [
    "FIRST_ISLANDS",
    "QUICK_ISLANDS",
    "RETURNED",
    "WARM_ISLANDS",
    "Island",
    "Outcome",
    "Population",
    "RunOptions",
    "pack_best",
    "run_request",
    "unpack_best",
]

#: Corners and steps of the waypoints of paths.
Population = Sequence[Sequence[tuple[int, int, int]]]
#: Paths that a run returns at most.
RETURNED = 8
#: Islands of a run at most.
_MOST_ISLANDS = 8
#: Bytes of a key on the link.
_KEY_BYTES = 4
#: Most halves of the climb limit of an :class:`Island`.
_MOST_SLOPE = 15


@dataclass(frozen=True)
class Island:
    """First population of an island: the surface that its route is found on.

    Parameters
    ----------
    mean : bool
        Take the mean ground of each block rather than the least.
    slope : int
        Raise the surface until no slope exceeds so many halves of the climb limit, 1..15; 0 leaves
        it as it is.
    """

    mean: bool
    slope: int


#: Four surfaces: two of the mean ground, which clear hills, and two of the least, which find gaps.
FIRST_ISLANDS = (Island(True, 2), Island(True, 5), Island(False, 3), Island(False, 0))
#: Two surfaces for a run of less than 3 ms, which four wavefronts would leave little of.
QUICK_ISLANDS = (Island(False, 3), Island(False, 0))
#: One surface, for an island of fresh seeds beside the population of a warm start.
WARM_ISLANDS = (Island(False, 3),)


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Options of a run.

    Parameters
    ----------
    seed : int
        0..2**64 - 1. All random draws follow from it.
    cycles, generations : int
        The run ends with the generation that reaches either number, of all islands together. The
        first populations are always completed.
    give_up_rank : int
        While the best path is feasible, a child is walked only if it is cheaper than the path of
        this rank.
    islands : tuple of Island
        1, 2, 4 or 8 of them, bred one after the other. The population of a warm start is one more,
        the first.
    seeds : int
        Paths seeded along each route, of which the best become the island's population.
    lifts : int
        Passes that raise each seed where it collides, 0..4.
    share : int
        Sixteenths of the time after the first populations that the islands have together.
    memo : int
        Rows of the memo of segments: 0, or a power of two. Changes nothing but cycles.
    """

    seed: int = 0
    cycles: int = 1_000_000
    generations: int = (1 << 32) - 1
    give_up_rank: int = 7
    islands: tuple[Island, ...] = FIRST_ISLANDS
    seeds: int = 128
    lifts: int = 4
    share: int = 8
    memo: int = 512

    def check(self, config: Config, population: Population | None = None) -> None:
        """Raise unless a chip of ``config`` can run this, on from ``population`` if it is given.

        Raises
        ------
        ValueError
            If a value is outside its range.
        """
        count = len(self.islands) + (population is not None)
        counts = "1, 2, 4 or 8" if population is None else "0, 1, 3 or 7 on a warm start"
        for name, rule, holds in (
            ("seed", "from 0 to 2**64 - 1", 0 <= self.seed < 1 << SEED_BITS),
            ("cycles", "from 0 to 2**32 - 1", 0 <= self.cycles < 1 << 32),
            ("generations", "from 0 to 2**32 - 1", 0 <= self.generations < 1 << 32),
            ("give_up_rank", "a rank", 0 <= self.give_up_rank < config.population),
            ("islands", counts, count in (1, 2, 4, 8)),
            ("islands", "at most the population", count <= config.population),
            (
                "islands",
                f"of slopes from 0 to {_MOST_SLOPE}",
                all(0 <= island.slope <= _MOST_SLOPE for island in self.islands),
            ),
            ("seeds", "from the population to 65535", config.population <= self.seeds < 1 << 16),
            ("lifts", "from 0 to 4", 0 <= self.lifts <= 4),
            ("share", "from 0 to 16", 0 <= self.share <= 16),
            (
                "memo",
                "0, or a power of two up to 65536",
                0 <= self.memo <= 1 << 16 and self.memo & self.memo - 1 == 0 and self.memo != 1,
            ),
        ):
            if not holds:
                raise ValueError(f"RunOptions.{name} must be {rule}, not {getattr(self, name)!r}")
        if population is not None:
            _check_population(config, population)

    def pack(self, config: Config) -> bytes:
        """Return the payload of a RUN, :func:`run_request`.

        Raises
        ------
        ValueError
            If a value is outside its range.
        """
        self.check(config)
        values = {
            name: getattr(self, name)
            for name, _ in run_request(config).fields
            if hasattr(self, name) and name != "islands"
        }
        for i in range(_MOST_ISLANDS):
            island = self.islands[i] if i < len(self.islands) else Island(False, 0)
            values |= {f"mean_{i}": int(island.mean), f"slope_{i}": island.slope}
        return run_request(config).pack(**values, islands=len(self.islands))

    @classmethod
    def unpack(cls, config: Config, payload: bytes) -> RunOptions:
        """Return the options in the payload of a RUN, the inverse of :meth:`pack`.

        Raises
        ------
        ValueError
            If the payload has another size, or a value is outside its range.
        """
        values = run_request(config).unpack(payload)
        count = values.pop("islands")
        islands = [
            Island(bool(values.pop(f"mean_{i}")), values.pop(f"slope_{i}"))
            for i in range(_MOST_ISLANDS)
        ]
        options = cls(**values, islands=tuple(islands[:count]))
        options.check(config)
        return options


def _check_population(config: Config, population: Population) -> None:
    if len(population) != config.population:
        raise ValueError(f"Population must have {config.population} paths, not {len(population)}")
    limits = config.map_size, config.map_size, config.blocked_altitude
    for path in population:
        if not config.MIN_WAYPOINTS <= len(path) <= config.max_waypoints:
            raise ValueError(
                f"A path of the population must have {config.MIN_WAYPOINTS} to "
                f"{config.max_waypoints} waypoints, not {len(path)}"
            )
        for waypoint in path:
            if not all(0 <= value < limit for value, limit in zip(waypoint, limits, strict=True)):
                raise ValueError(
                    f"A waypoint of the population must be within {limits}, not {waypoint!r}"
                )


@dataclass(frozen=True)
class Outcome:
    """Result of a run.

    Attributes
    ----------
    paths : list of list of (int, int, int)
        Up to 8 paths of different keys, the best first: corners and steps of their waypoints, start
        and goal left out.
    keys : list of int
        Their keys.
    generations : int
        Generations bred, on all islands together.
    cycles : int
        Cycles of the run, as :mod:`sim.model.planner.cycles` estimates them.
    population : list of list of (int, int, int)
        All paths at the end, the best first: what a warm start goes on from.
    """

    paths: list[list[tuple[int, int, int]]]
    keys: list[int]
    generations: int
    cycles: int
    population: list[list[tuple[int, int, int]]]

    @property
    def classes(self) -> list[PathClass]:
        """Classes of the paths."""
        return [PathClass(key >> VALUE_BITS) for key in self.keys]


def run_request(config: Config) -> Layout:
    """Return the fields of a RUN: those of :class:`RunOptions`; the size of the memo is built in.

    ``islands`` is their number; ``mean`` and ``slope`` of those beyond mean nothing.
    """
    return Layout(
        (
            ("seed", SEED_BITS),
            ("cycles", 32),
            ("generations", 32),
            ("give_up_rank", 8),
            ("seeds", 16),
            ("lifts", 3),
            ("share", 5),
            ("islands", 8),
            *numbered("mean", _MOST_ISLANDS, 1),
            *numbered("slope", _MOST_ISLANDS, 4),
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
