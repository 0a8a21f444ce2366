"""The genetic core: population, draws and one generation at a time."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

from hdl.config import Config
from sim.model.crossover import crossover
from sim.model.mutation import Limits, Mutated, Mutation
from sim.model.random_source import RandomSource
from sim.model.selection import Draws, Selection


__all__ = ["Core", "Generation"]


@dataclass(frozen=True)
class Generation:
    """What one generation did.

    Attributes
    ----------
    parents, survivors : tuple of int
        Slots, before the update, of the crossover parents and of the survivors.
    mutations : list of Mutated
    crossover_clocks, mutation_clocks, update_clocks : int
        Predicted clocks of each unit.
    """

    parents: tuple[int, ...]
    survivors: tuple[int, ...]
    mutations: list[Mutated]
    crossover_clocks: int
    mutation_clocks: int
    update_clocks: int


class Core:
    """The genetic core.

    Slots of the population after a generation: the elites, best first; the survivors in the order
    drawn; the children. A path is a list of packed waypoints.

    Attributes
    ----------
    paths : list of list of int
        Content of every slot.
    generation : int
        Generations since :meth:`start`.
    """

    #: Clocks of the mutators after the last waypoint has passed: move and clamp, then store.
    MUTATION_CLOCKS = 2
    #: Clocks of the population update (*allaire-2008*, section 4.4).
    UPDATE_CLOCKS = 1

    def __init__(self, config: Config) -> None:
        self.config = config
        self.paths: list[list[int]] = [[0] * config.MIN_WAYPOINTS for _ in range(config.population)]
        self.generation = 0
        self.limits = Limits(config.map_size - 1, config.map_size - 1, config.blocked_altitude - 1)
        self._selection = Selection(config)
        self._mutation = Mutation(config)
        self._source: RandomSource | None = None
        self._draws: Draws | None = None
        self.start(0, self.limits)

    def start(self, seed: int, limits: Limits) -> None:
        """Seed the random source, set the limits of new waypoints, count from generation 0."""
        self._source = RandomSource(seed)
        self.limits = limits
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
        kept = [self.paths[slot] for slot in (*order[: config.elites], *survivors)]
        bred = [self.paths[slot] for slot in parents]

        children = crossover(bred)
        mutations = self._mutation.mutate(children, draws, self.limits)
        self.paths = kept + children
        self.generation += 1
        self._draws = self._selection.draw(self._source)

        # All paths are read in lock step; a waypoint read is written one clock later.
        longest = max(map(len, kept + bred))
        return Generation(
            parents, survivors, mutations, longest + 1, self.MUTATION_CLOCKS, self.UPDATE_CLOCKS
        )

    def checksum(self) -> int:
        """CRC-32 of the population as :meth:`hdl.protocol.pack_paths` sends it, slot by slot."""
        from hdl.protocol import pack_paths

        return zlib.crc32(pack_paths(self.config, self.paths))
