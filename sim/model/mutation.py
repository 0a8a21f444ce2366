"""Model of the mutation unit: each mutator changes one child, in place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pathgene.hdl.config import CheckerBuild, Config, MutationKind
from pathgene.hdl.protocol.breeding import MutationRecord, may_mutate, mutate
from pathgene.sim.model.selection import Draws


if TYPE_CHECKING:
    from pathgene.sim.model.checker import TerrainModel

__all__ = ["Limits", "Mutated", "Mutation", "clamp"]


@dataclass(frozen=True)
class Limits:
    """Maximum x, y and altitude of a new waypoint, which the host sets within the map."""

    x: int
    y: int
    altitude: int


@dataclass(frozen=True)
class Mutated(MutationRecord):
    """Effect of one mutator, and the draws that it needed.

    Attributes
    ----------
    redraws : int
        Number of repeated draws of the new waypoint because earlier draws were in the ground.
    left_out : bool
        All draws of the new waypoint were in the ground.
    """

    redraws: int = 0
    left_out: bool = False


def clamp(value: int, high: int) -> int:
    """Return ``value`` limited to 0..high."""
    return 0 if value < 0 else min(value, high)


class Mutation:
    """All mutators of the chip.

    Parameters
    ----------
    terrain : TerrainModel, optional
        The map on the chip; required if ``config.checker`` has one.

    Raises
    ------
    ValueError
        If there is a map although the chip has none, or the reverse.
    """

    def __init__(self, config: Config, terrain: TerrainModel | None = None) -> None:
        if (terrain is None) != (config.checker is CheckerBuild.NONE):
            raise ValueError(
                f"Config.checker must be none without a map and not with one, not {config.checker}"
            )
        self._config = config
        self._terrain = terrain

    def mutate(
        self,
        children: list[list[int]],
        draws: Draws,
        limits: Limits,
        avoid_ground: bool = False,
    ) -> list[Mutated]:
        """Change ``children`` according to ``draws``; return the effect of each mutator.

        The mutators work on different children, so their order does not matter. With
        ``avoid_ground``, a new waypoint is the first of its candidates that is above the ground; if
        there is none, the mutation is not applied. Otherwise, or without a map, a new waypoint is
        its first candidate.
        """
        done = []
        for number, kind in enumerate(self._config.mutations):
            child = draws.children[number]
            path = children[child]
            index = draws.waypoints[number] * len(path) >> 16
            applied = may_mutate(self._config, kind, len(path))
            if kind is MutationKind.DELETE or not applied:
                mutated = Mutated(kind, applied, child, index, 0)
            else:
                candidates = self._candidates(path[index], number, draws, limits)
                if not avoid_ground:
                    del candidates[1:]
                grounded = [avoid_ground and self._is_grounded(each) for each in candidates]
                if all(grounded):
                    redraws = len(candidates) - 1
                    mutated = Mutated(kind, False, child, index, 0, redraws, left_out=True)
                else:
                    redraws = grounded.index(False)
                    mutated = Mutated(kind, True, child, index, candidates[redraws], redraws)
            mutate(children, mutated)
            done.append(mutated)
        return done

    def _candidates(self, waypoint: int, number: int, draws: Draws, limits: Limits) -> list[int]:
        offsets = draws.offsets[number :: self._config.patches]
        return [self._moved(waypoint, offset, limits) for offset in offsets]

    def _moved(self, waypoint: int, offset: tuple[int, int, int], limits: Limits) -> int:
        x, y, altitude = self._unpacked(waypoint)
        x = clamp(x + offset[0], limits.x)
        y = clamp(y + offset[1], limits.y)
        altitude = clamp(altitude + offset[2], limits.altitude)
        bits = self._config.coordinate_bits
        return x | y << bits | altitude << 2 * bits

    def _is_grounded(self, waypoint: int) -> bool:
        if self._terrain is None:
            return False
        x, y, altitude = self._unpacked(waypoint)
        return altitude <= int(self._terrain.heights[y, x])

    def _unpacked(self, waypoint: int) -> tuple[int, int, int]:
        bits = self._config.coordinate_bits
        mask = (1 << bits) - 1
        return waypoint & mask, waypoint >> bits & mask, waypoint >> 2 * bits
