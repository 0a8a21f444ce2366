"""Model of the paper core: population, draws and one generation at a time."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.protocol.breeding import Recipe, crossover, keep
from pathgene.hdl.protocol.paths import pack_paths
from pathgene.sim.model.checker import TerrainModel
from pathgene.sim.model.mutation import Limits, Mutated, Mutation
from pathgene.sim.model.random_source import RandomSource
from pathgene.sim.model.selection import Draws, Selection


__all__ = ["Generation", "PaperCore"]


@dataclass(frozen=True)
class Generation:
    """Effect of one generation.

    Attributes
    ----------
    parents, survivors : tuple of int
        Slots, before the update, of the crossover parents and of the survivors.
    mutations : list of Mutated
    crossover_cycles, mutation_cycles, update_cycles : int
        Cycles of each unit.
    """

    parents: tuple[int, ...]
    survivors: tuple[int, ...]
    mutations: list[Mutated]
    crossover_cycles: int
    mutation_cycles: int
    update_cycles: int

    @property
    def recipe(self) -> Recipe:
        """The choices of the generation."""
        return Recipe(self.parents, self.survivors, tuple(self.mutations))

    @property
    def redrawn(self) -> int:
        """Number of repeated draws of new waypoints because of the ground."""
        return sum(mutated.redraws for mutated in self.mutations)

    @property
    def left_out(self) -> int:
        """Number of mutations that were not applied because of the ground."""
        return sum(mutated.left_out for mutated in self.mutations)

    @property
    def refused(self) -> int:
        """Number of mutations that a length limit forbade."""
        return sum(not mutated.applied for mutated in self.mutations) - self.left_out


class PaperCore:
    """The paper core.

    Slots of the population after a generation: the elites, best first; the survivors in the order
    drawn; the children. A path is a list of packed waypoints.

    Parameters
    ----------
    terrain : TerrainModel, optional
        The map on the chip, if ``config.checker`` has one. By default, the core makes one.

    Attributes
    ----------
    paths : list of list of int
        Content of every slot.
    generation : int
        Generations since :meth:`start`.
    avoid_ground : bool
        Values set by :meth:`start`.
    """

    #: Cycles of the mutators after the last waypoint: move and clamp, then store.
    MUTATION_CYCLES = 2
    #: Cycles of the population update (*allaire-2008*, section 4.4).
    UPDATE_CYCLES = 1
    #: Cycles, not counting the lookup, from a candidate to the state after its mutation: move,
    #: clamp, compare, decide, store.
    CANDIDATE_CYCLES = 5

    def __init__(self, config: Config, terrain: TerrainModel | None = None) -> None:
        self.config = config
        self.paths: list[list[int]] = [[0] * config.MIN_WAYPOINTS for _ in range(config.population)]
        self.generation = 0
        self.limits = Limits(config.map_size - 1, config.map_size - 1, config.blocked_altitude - 1)
        if terrain is None and config.checker is not CheckerBuild.NONE:
            terrain = TerrainModel(config)
        self._selection = Selection(config)
        self._mutation = Mutation(config, terrain)
        self._source: RandomSource | None = None
        self._draws: Draws | None = None
        self.start(0, self.limits)

    def start(self, seed: int, limits: Limits, avoid_ground: bool = False) -> None:
        """Seed the random source, set the limits of new waypoints, count from generation 0.

        With ``avoid_ground``, new waypoints in the ground are rejected; without a map, none is.
        """
        self._source = RandomSource(seed)
        self.limits = limits
        self.avoid_ground = avoid_ground
        self.generation = 0
        self._draws = self._selection.draw(self._source)

    def run(self, order: Sequence[int]) -> Generation:
        """Run one generation.

        Parameters
        ----------
        order : sequence of int
            The slots from the best path to the worst: a permutation of 0..population - 1.
        """
        config, draws = self.config, self._draws
        assert self._source is not None
        assert draws is not None
        parents = tuple(order[rank] for rank in draws.parents)
        survivors = tuple(order[rank] for rank in draws.survivors)
        kept = [self.paths[slot] for slot in keep(config, order, survivors)]
        bred = [self.paths[slot] for slot in parents]

        children = crossover(bred)
        mutations = self._mutation.mutate(children, draws, self.limits, self.avoid_ground)
        self.paths = kept + children
        self.generation += 1
        self._draws = self._selection.draw(self._source)

        # All paths are read in lockstep; a waypoint is written one cycle after it is read.
        crossover_cycles = max(map(len, kept + bred)) + 1
        mutation_cycles = max(
            self.MUTATION_CYCLES, self._candidates_cycles(mutations) - crossover_cycles
        )
        return Generation(
            parents, survivors, mutations, crossover_cycles, mutation_cycles, self.UPDATE_CYCLES
        )

    def _candidates_cycles(self, mutations: list[Mutated]) -> int:
        """Return the cycles from the start of a generation until all new waypoints are stored."""
        config = self.config
        if config.checker is CheckerBuild.NONE:
            return 0
        # One candidate per cycle, in rounds of one per patch, up to the last that matters.
        candidates = max(
            mutated.redraws * config.patches + number + 1
            for number, mutated in enumerate(mutations[: config.patches])
            if mutated.applied or mutated.left_out
        )
        return candidates + config.lookup_latency + self.CANDIDATE_CYCLES

    def checksum(self) -> int:
        """Return the CRC-32 of the population as ``pack_paths`` sends it, slot by slot."""
        return zlib.crc32(pack_paths(self.config, self.paths))
