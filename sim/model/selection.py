"""Model of the selection unit: the draws of one generation."""

from __future__ import annotations

from dataclasses import dataclass

from pathgene.hdl.config import Config, SurvivorSelection
from pathgene.hdl.protocol.random_words import RandomWordLayout, Slice
from pathgene.sim.model.random_source import RandomSource


__all__ = ["DistinctDraw", "Draws", "Selection"]


def _slice(word: int, at: Slice) -> int:
    return word >> at[0] & ((1 << (at[1] - at[0])) - 1)


def _below(word: int, at: Slice, limit: int) -> int:
    return _slice(word, at) * limit >> (at[1] - at[0])


@dataclass(frozen=True)
class Draws:
    """All random choices of one generation, in ranks and fractions.

    Attributes
    ----------
    parents : tuple of int
        Rank of each of the ``crossovers`` parents; 0 is the best. P(r) = (2 (N - r) - 1) / N**2.
    survivors : tuple of int
        Distinct ranks from ``elites`` to ``population - 1``, in the order drawn.
    children : tuple of int
        Distinct children, one for each mutator.
    waypoints : tuple of int
        16 bits for each mutator: its waypoint is ``bits * length >> 16``.
    offsets : tuple of (int, int, int)
        Steps in x, y and altitude, each within the box: for the first candidate of each mutator
        that makes a waypoint, then for their second candidates, up to ``config.candidates``.
    """

    parents: tuple[int, ...]
    survivors: tuple[int, ...]
    children: tuple[int, ...]
    waypoints: tuple[int, ...]
    offsets: tuple[tuple[int, int, int], ...]


class DistinctDraw:
    """Draws distinct numbers below ``total``, one per call.

    A draw ``d`` selects among the remaining numbers in increasing order: the result is ``d`` plus
    the count of earlier results at or below it. The gateware compares with all of them at once: it
    stores ``e_j = c_j - j`` of the sorted results ``c_j``, for which that count is the number of
    ``e_j <= d``.
    """

    def __init__(self, total: int) -> None:
        self._total = total
        self._lowered: list[int] = []

    @property
    def left(self) -> int:
        """Number of the numbers not yet drawn."""
        return self._total - len(self._lowered)

    def take(self, draw: int) -> int:
        """Return the remaining number at index ``draw`` (0..left - 1), and remove it."""
        below = sum(e <= draw for e in self._lowered)
        self._lowered = [
            *self._lowered[:below],
            draw,
            *(e - 1 for e in self._lowered[below:]),
        ]
        return draw + below


class Selection:
    """The selection unit, which makes the draws of the next generation during the current one."""

    def __init__(self, config: Config) -> None:
        self._config = config
        self._layout = RandomWordLayout(config)

    def draw(self, source: RandomSource) -> Draws:
        """Take ``config.draw_steps`` steps of ``source`` and return the draws."""
        config, layout = self._config, self._layout
        words = [source.step() for _ in range(config.draw_steps)]
        first = [word[0] for word in words]
        second = [word[1] for word in words]

        parents = tuple(
            min(_slice(word, layout.rank_first), _slice(word, layout.rank_second))
            for word in first[: config.crossovers]
        )

        others = DistinctDraw(config.population - config.elites)
        survivors = []
        for word in first[: config.survivors]:
            draw = _below(word, layout.survivor_first, others.left)
            if config.survivor_selection is SurvivorSelection.RANK:
                draw = min(draw, _below(word, layout.survivor_second, others.left))
            survivors.append(config.elites + others.take(draw))

        pool = DistinctDraw(config.children)
        children = tuple(
            pool.take(_below(word, layout.child, pool.left)) for word in second[: config.mutators]
        )
        waypoints = tuple(_slice(word, layout.waypoint) for word in second[: config.mutators])

        boxes = (config.box_cells, config.box_cells, config.box_steps)
        offsets = []
        offsets_end = config.mutators + config.patches * config.candidates
        for word in second[config.mutators : offsets_end]:
            x, y, altitude = (
                _below(word, at, 2 * box + 1) - box
                for at, box in zip(layout.offsets, boxes, strict=True)
            )
            offsets.append((x, y, altitude))

        return Draws(parents, tuple(survivors), children, waypoints, tuple(offsets))
