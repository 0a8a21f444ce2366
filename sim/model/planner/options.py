"""Options of a run, and its outcome."""

from __future__ import annotations

from dataclasses import dataclass

from hdl.config import Config
from hdl.protocol.planner import VALUE_BITS, PathClass
from sim.model.random_source import check_seed


__all__ = ["FIRST_ISLANDS", "QUICK_ISLANDS", "RETURNED", "Island", "Outcome", "RunOptions"]

#: Paths that a run returns at most.
RETURNED = 8
#: The ranks of a child's parents leave 24 bits of a selection word for a survivor.
_MOST_POPULATION = 32
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
        1, 2, 4 or 8 of them, bred one after the other.
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
    generations: int = 1 << 30
    give_up_rank: int = 7
    islands: tuple[Island, ...] = FIRST_ISLANDS
    seeds: int = 128
    lifts: int = 4
    share: int = 8
    memo: int = 512

    def check(self, config: Config) -> None:
        """Raise unless a chip of ``config`` can run this.

        Raises
        ------
        ValueError
            If a value is outside its range.
        """
        check_seed(self.seed)
        for name, rule, holds in (
            ("cycles", "0 or more", self.cycles >= 0),
            ("generations", "0 or more", self.generations >= 0),
            ("give_up_rank", "a rank", 0 <= self.give_up_rank < config.population),
            ("islands", "1, 2, 4 or 8", len(self.islands) in (1, 2, 4, 8)),
            ("islands", "at most the population", len(self.islands) <= config.population),
            (
                "islands",
                f"of slopes from 0 to {_MOST_SLOPE}",
                all(0 <= island.slope <= _MOST_SLOPE for island in self.islands),
            ),
            ("seeds", "from the population on", config.population <= self.seeds <= 1 << 16),
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
        if config.survivors > config.children:
            raise ValueError(
                f"Config.survivors must be at most Config.children for a planner on the chip, "
                f"not {config.survivors!r}"
            )
        if config.population > _MOST_POPULATION:
            raise ValueError(
                f"Config.population must be at most {_MOST_POPULATION} for a planner on the chip, "
                f"not {config.population!r}"
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
    """

    paths: list[list[tuple[int, int, int]]]
    keys: list[int]
    generations: int
    cycles: int

    @property
    def classes(self) -> list[PathClass]:
        """Classes of the paths."""
        return [PathClass(key >> VALUE_BITS) for key in self.keys]
