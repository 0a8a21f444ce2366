"""A run: first populations, islands, and one population of their best.

Generations overlap, as in the gateware: while the children of one are evaluated, those of the next
are bred. So a generation is bred from the population that the one before was bred from, and the
children of the generation before that.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import BLOCKS, VALUE_BITS, PathClass, ProblemRecord
from pathgene.hdl.protocol.runs import ISLANDS, Outcome, Population, RunOptions
from pathgene.sim.model.planner import cycles
from pathgene.sim.model.planner.definition.breeder import Waypoint, breed
from pathgene.sim.model.planner.definition.evaluation import NO_LIMIT, Evaluator
from pathgene.sim.model.planner.definition.memo import Memo
from pathgene.sim.model.planner.definition.seeds import lifted, seed_path
from pathgene.sim.model.planner.definition.sorting import Sorting
from pathgene.sim.model.planner.definition.walk import Ground
from pathgene.sim.model.planner.definition.warm import ahead
from pathgene.sim.model.planner.definition.wavefront import (
    blocks_of,
    descend,
    limit_slopes,
    prices_of,
    spread,
)
from pathgene.sim.model.planner.run_control_cycles import ROUTED, SCANNED
from pathgene.sim.model.planner.wavefront_cycles import launched, scanned
from pathgene.sim.model.random_source import RandomSource


__all__ = ["NEVER", "Generation", "Member", "Run", "check_population", "plan"]


@dataclass(frozen=True)
class Member:
    """A path of a population, and its key."""

    path: list[Waypoint]
    key: int


@dataclass(frozen=True)
class Evaluated:
    """A member, and the cycle in which its key is made."""

    member: Member
    made: int


@dataclass(frozen=True)
class Generation:
    """Children that are to be evaluated.

    Attributes
    ----------
    children : list of list of Waypoint
    offered : list of int
        Cycles in which their second points are there.
    first : bool
        The best path of the population that they were bred from is feasible.
    limit : int
        Value that a path must be below to be walked, if ``first``.
    kept : list of int
        Ranks of the members of a population that stay: elites, and the survivors drawn.
    """

    children: list[list[Waypoint]]
    offered: list[int]
    first: bool
    limit: int
    kept: list[int]


#: Feasible paths have lesser keys.
_GIVEN_UP = PathClass.GIVEN_UP << VALUE_BITS
#: Cycle of a stop that does not come: the counter of cycles ends before.
NEVER = 1 << 32


def plan(
    config: Config,
    ground: Ground,
    record: ProblemRecord,
    options: RunOptions,
    population: Population | None = None,
    *,
    marked: int = BLOCKS**2,
    stop: int = NEVER,
) -> Outcome:
    """Plan a path.

    Parameters
    ----------
    config : Config
    ground : ndarray
        ``(map_size, map_size)`` uint16: the highest of the four cells around each corner.
    record : ProblemRecord
    options : RunOptions
    population : list of list of (int, int, int), optional
        All paths of an earlier run, the best first; only with ``options.warm``.
    marked : int
        Blocks of the map that have changed since the run before, by default all. Changes nothing
        but cycles.
    stop : int
        Cycle in which the run is stopped: no further generation is bred from the next one on.

    Raises
    ------
    ValueError
        If the options, the record or the population do not fit ``config``.
    """
    options.check(config)
    record.pack(config)
    check_population(config, options, population)
    return Run(config, ground, record, options, stop).plan(population, marked)


def check_population(config: Config, options: RunOptions, population: Population | None) -> None:
    """Raise ``ValueError`` unless a warm run has a whole population, and another one has none."""
    count = 0 if population is None else len(population)
    if count != (config.population if options.warm else 0):
        raise ValueError(
            f"A warm run must go on from {config.population} paths, and another run from none, not "
            f"from {count}"
        )


class Run:
    """State of a run; see :func:`plan`."""

    def __init__(
        self,
        config: Config,
        ground: Ground,
        record: ProblemRecord,
        options: RunOptions,
        stop: int = NEVER,
    ) -> None:
        self.config, self.record, self.options, self._stop = config, record, options, stop
        self._blocks = blocks_of(record, ground, config.blocked_altitude)
        self._evaluator = Evaluator(config, record, ground, Memo(config, options.memo))
        self._source = RandomSource(options.seed)
        self._delays = cycles.delays_vector(config)
        self._counters = cycles.counters_vector()

    def plan(self, population: Population | None, marked: int) -> Outcome:
        """Do the run."""
        options, counters = self.options, self._counters
        self._scan(marked)
        islands = [] if population is None else [self.revive(population)]
        islands += [self.seed(slope) for slope in options.slopes]
        if len(islands) == ISLANDS:
            left = max(options.cycles - int(counters[cycles.CYCLES]), 0)
            time = left * options.share >> 5
            generations = options.generations * options.share >> 5
            cycles.share_out(counters)
            for number, island in enumerate(islands):
                if number:
                    cycles.next_island(counters)
                ends = int(counters[cycles.CYCLES]) + time
                most = int(counters[cycles.GENERATIONS]) + generations
                cycles.aim(counters)
                islands[number] = self.evolve(island, ends, most)
            each = self.config.population // ISLANDS
            stay = [member for island in islands for member in island[:each]]
            cycles.merge(self._delays, counters, _passed(self._sorting(), stay))
            islands = [_sorted(stay)]
        else:
            cycles.aim(counters)
        members = self.evolve(islands[0], options.cycles, options.generations, is_final=True)
        cycles.end(counters)
        best: dict[int, Member] = {}
        for member in members:
            best.setdefault(member.key, member)
        returned = list(best.values())[: options.paths]
        return Outcome(
            [[waypoint[:3] for waypoint in member.path] for member in returned],
            [member.key for member in returned],
            [[waypoint[:3] for waypoint in member.path] for member in members],
            **cycles.totals(counters),
        )

    def revive(self, population: Population) -> list[Member]:
        """Return an earlier population as it is now, from the new start on, sorted."""
        members, sorting = [], self._sorting()
        for number, path in enumerate(population):
            left = [Waypoint(*point) for point in ahead(self.config, self.record, path)]
            dropped = len(path) - len(left)
            offered = cycles.revised(self._counters, number, dropped)
            members.append(self._sorted_in(sorting, self._evaluated(left, offered)))
        cycles.settle(self._delays, self._counters)
        return _sorted(members)

    def seed(self, slope: int) -> list[Member]:
        """Return the first population of an island, sorted."""
        record, blocks, options = self.record, self._blocks, self.options
        surface = dict(blocks.least)
        limit_passes = limit_slopes(record, blocks, surface, slope) if slope else 0
        prices = prices_of(self.config, record, blocks.distances)
        field, passes = spread(prices, blocks, surface)
        route = descend(prices, blocks, surface, field)
        spent = launched(limit_passes, passes, len(route), blocks.start not in field)
        cycles.spread(self._counters, spent, ROUTED)
        members, sorting = [], self._sorting()
        for number in range(options.seeds):
            path = seed_path(self.config, record, blocks, surface, route, self._source)
            offered = cycles.seeded(self._counters, number)
            members.append(self._sorted_in(sorting, self._evaluated(path, offered)))
        cycles.settle(self._delays, self._counters)
        members = _sorted(members)[: self.config.population]
        for _ in range(options.lifts):
            members = self.lift(members)
        return members

    def lift(self, population: list[Member]) -> list[Member]:
        """Return a population out of the ground, as far as one pass raises it."""
        members, sorting = [], self._sorting()
        for number, member in enumerate(population):
            path = lifted(self.record, member.path)
            offered = cycles.revised(self._counters, number, 0)
            members.append(self._sorted_in(sorting, self._evaluated(path, offered)))
        cycles.settle(self._delays, self._counters)
        return _sorted(members)

    def evolve(
        self, population: list[Member], time: int, generations: int, *, is_final: bool = False
    ) -> list[Member]:
        """Return ``population`` after so many cycles or generations of the run."""
        counters = self._counters
        pending = None
        time = min(time, self._stop + 1)
        waits = is_final and self.options.until_feasible
        while counters[cycles.CYCLES] < time and (
            counters[cycles.GENERATIONS] < generations or (waits and population[0].key >= _GIVEN_UP)
        ):
            latest = self.breed(population, pending=pending is not None)
            if pending is not None:
                population = self.collect(population, latest.kept, pending)
            pending = latest
        if pending is not None:
            cycles.finish(counters)
            population = self.collect(population, pending.kept, pending)
        return population

    def breed(self, population: list[Member], *, pending: bool) -> Generation:
        """Return the children of a population. ``pending``: those before are not collected."""
        config, record, evaluator = self.config, self.record, self._evaluator
        begun = cycles.begin(self._delays, self._counters, pending)
        paths = [member.path for member in population]
        children, survivors = breed(config, record, evaluator.ends, paths, self._source)
        offered = [
            cycles.bred(self._counters, begun, number, len(child) + 2)
            for number, child in enumerate(children)
        ]
        limit = population[self.options.give_up_rank].key
        return Generation(
            children,
            offered,
            population[0].key < _GIVEN_UP,
            limit if limit < _GIVEN_UP else NO_LIMIT,
            sorted([*range(config.elites), *survivors]),
        )

    def collect(
        self, population: list[Member], kept: Iterable[int], pending: Generation
    ) -> list[Member]:
        """Return the next population, sorted; of equals, the members that stay come first."""
        stay = [population[rank] for rank in kept]
        children: list[Member] = []
        sorting, passes = self._sorting(), False
        for path, offered in zip(pending.children, pending.offered, strict=True):
            evaluated = self._evaluated(path, offered, pending.limit, first=pending.first)
            if not passes and cycles.passes(self._counters, evaluated.made):
                passes = True
                self._pass_over(sorting, stay)
            children.append(self._sorted_in(sorting, evaluated))
        if not passes:
            self._pass_over(sorting, stay)
        cycles.collect(self._delays, self._counters)
        return _sorted([*stay, *children])

    def _pass_over(self, sorting: Sorting, stay: list[Member]) -> None:
        cycles.pass_over(self._delays, self._counters, _passed(sorting, stay))

    def _sorted_in(self, sorting: Sorting, evaluated: Evaluated) -> Member:
        """Let the sorter take the key of the latest path; return the member."""
        passed = sorting.insert(evaluated.member.key, late=True)
        cycles.take(self._counters, evaluated.made, passed)
        return evaluated.member

    def _sorting(self) -> Sorting:
        return Sorting(self.config.population)

    def _scan(self, marked: int) -> None:
        latency = int(self._delays[cycles.ROW])
        spent = scanned(marked, self.record.block_shift, self.config.lanes, latency)
        cycles.spread(self._counters, spent, SCANNED)

    def _evaluated(
        self, path: list[Waypoint], offered: int, limit: int = NO_LIMIT, *, first: bool = False
    ) -> Evaluated:
        evaluator, record = self._evaluator, self.record
        start, goal = evaluator.ends
        points = [start, *(waypoint[:3] for waypoint in path), goal]
        margins = [0, *(waypoint.margin for waypoint in path), 0]
        before = evaluator.walk
        key = evaluator.evaluate(points, margins, limit, first=first)
        walk = evaluator.walk - before
        self._counters[cycles.WALK] += walk
        count = len(points) + record.has_entry + record.has_exit
        exits = record.has_exit
        made = cycles.enter(self._delays, self._counters, offered, count, walk, exits)
        measured = [
            waypoint._replace(margin=margin)
            for waypoint, margin in zip(path, margins[1:-1], strict=True)
        ]
        return Evaluated(Member(measured, key), made)


def _passed(sorting: Sorting, stay: list[Member]) -> int:
    """Insert members that stay; return how many others they pass, all together."""
    return sum(sorting.insert(member.key, late=False) for member in stay)


def _sorted(members: list[Member]) -> list[Member]:
    """Return members by their keys; of equals, the earlier first."""
    return sorted(members, key=lambda member: member.key)
