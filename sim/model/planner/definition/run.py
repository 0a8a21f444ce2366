"""A run: first populations, islands, and one population of their best."""

from __future__ import annotations

from dataclasses import dataclass

from hdl.config import Config
from hdl.protocol.planner import VALUE_BITS, PathClass, ProblemRecord
from hdl.protocol.runs import RETURNED, Island, Outcome, Population, RunOptions
from sim.model.planner.cycles import VISITS_PER_PASS, overlapped
from sim.model.planner.definition.breeder import Waypoint, breed
from sim.model.planner.definition.evaluation import NO_LIMIT, Evaluator
from sim.model.planner.definition.memo import Memo
from sim.model.planner.definition.seeds import lift, seed_path
from sim.model.planner.definition.walk import Ground
from sim.model.planner.definition.warm import ahead
from sim.model.planner.definition.wavefront import blocks_of, descend, limit_slopes, spread
from sim.model.random_source import RandomSource


__all__ = ["Member", "Run", "plan"]


@dataclass(frozen=True)
class Member:
    """A path of a population, and its key."""

    path: list[Waypoint]
    key: int


def plan(
    config: Config,
    ground: Ground,
    record: ProblemRecord,
    options: RunOptions,
    population: Population | None = None,
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
        All paths of an earlier run, the best first, for a warm start: an island of its own, before
        those of the options.

    Raises
    ------
    ValueError
        If the options, the record or the population do not fit ``config``.
    """
    options.check(config, population)
    record.pack(config)
    return Run(config, ground, record, options).plan(population)


class Run:
    """State of a run; see :func:`plan`."""

    def __init__(
        self, config: Config, ground: Ground, record: ProblemRecord, options: RunOptions
    ) -> None:
        self.config, self.record, self.options = config, record, options
        self._blocks = blocks_of(record, ground, config.blocked_altitude)
        self._evaluator = Evaluator(config, record, ground, Memo(config, options.memo))
        self._source = RandomSource(options.seed)
        self.cycles = self.generations = 0

    def plan(self, population: Population | None) -> Outcome:
        """Do the run."""
        options = self.options
        islands = [] if population is None else [self.revive(population)]
        islands += [self.seed(island) for island in options.islands]
        if len(islands) > 1:
            parts = 16 * len(islands)
            cycles = max(options.cycles - self.cycles, 0) * options.share // parts
            generations = options.generations * options.share // parts
            islands = [
                self.evolve(island, self.cycles + cycles, self.generations + generations)
                for island in islands
            ]
        each = self.config.population // len(islands)
        merged = _sorted([member for island in islands for member in island[:each]])
        members = self.evolve(merged, options.cycles, options.generations)
        best: dict[int, Member] = {}
        for member in members:
            best.setdefault(member.key, member)
        returned = list(best.values())[:RETURNED]
        return Outcome(
            [[waypoint[:3] for waypoint in member.path] for member in returned],
            [member.key for member in returned],
            self.generations,
            self.cycles,
            [[waypoint[:3] for waypoint in member.path] for member in members],
        )

    def revive(self, population: Population) -> list[Member]:
        """Return an earlier population as it is now, from the new start on, sorted."""
        members = []
        for path in population:
            left = [Waypoint(*point) for point in ahead(self.config, self.record, path)]
            members.append(self._evaluated(left, NO_LIMIT, first=False))
        self._settle()
        return _sorted(members)

    def seed(self, island: Island) -> list[Member]:
        """Return the first population of an island, sorted."""
        record, blocks, options = self.record, self._blocks, self.options
        surface = dict(blocks.mean if island.mean else blocks.least)
        passes = limit_slopes(record, blocks, surface, island.slope) if island.slope else 0
        field, further = spread(record, blocks, surface)
        self.cycles += (passes + further) * VISITS_PER_PASS
        route = descend(record, blocks, surface, field)
        seeds = []
        for _ in range(options.seeds):
            path = seed_path(self.config, record, blocks, surface, route, self._source)
            for _ in range(options.lifts):
                path, was_raised = lift(record, self._evaluator, path)
                if not was_raised:
                    break
            seeds.append(self._evaluated(path, NO_LIMIT, first=False))
        self._settle()
        return _sorted(seeds)[: self.config.population]

    def evolve(self, population: list[Member], cycles: int, generations: int) -> list[Member]:
        """Return ``population`` after so many cycles or generations of the run."""
        while self.cycles < cycles and self.generations < generations:
            population = self.breed(population)
        return population

    def breed(self, population: list[Member]) -> list[Member]:
        """Return the next generation, sorted; of equals, elites, survivors and children in turn."""
        config, evaluator = self.config, self._evaluator
        paths = [member.path for member in population]
        children, survivors = breed(config, self.record, evaluator.ends, paths, self._source)
        first = population[0].key < PathClass.GIVEN_UP << VALUE_BITS
        limit = population[self.options.give_up_rank].key
        if limit >= PathClass.GIVEN_UP << VALUE_BITS:
            limit = NO_LIMIT
        kept = [*population[: config.elites], *(population[rank] for rank in survivors)]
        bred = [self._evaluated(child, limit, first=first) for child in children]
        self._settle()
        self.generations += 1
        return _sorted([*kept, *bred])

    def _evaluated(self, path: list[Waypoint], limit: int, *, first: bool) -> Member:
        start, goal = self._evaluator.ends
        points = [start, *(waypoint[:3] for waypoint in path), goal]
        margins = [0, *(waypoint.margin for waypoint in path), 0]
        key = self._evaluator.evaluate(points, margins, limit, first=first)
        measured = [
            waypoint._replace(margin=margin)
            for waypoint, margin in zip(path, margins[1:-1], strict=True)
        ]
        return Member(measured, key)

    def _settle(self) -> None:
        evaluator = self._evaluator
        self.cycles += overlapped(evaluator.segments, evaluator.walker)
        evaluator.segments = evaluator.walker = 0


def _sorted(members: list[Member]) -> list[Member]:
    """Return members by their keys; of equals, the earlier first."""
    return sorted(members, key=lambda member: member.key)
