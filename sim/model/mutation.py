"""Mutation: each mutator changes one child, in place."""

from __future__ import annotations

from dataclasses import dataclass

from hdl.config import Config, MutationKind
from sim.model.selection import Draws


__all__ = ["Limits", "Mutated", "Mutation", "clamp"]


@dataclass(frozen=True)
class Limits:
    """Highest x, y and altitude a new waypoint may have; set by the host, within the map."""

    x: int
    y: int
    altitude: int


@dataclass(frozen=True)
class Mutated:
    """What one mutator did.

    Attributes
    ----------
    kind : MutationKind
    applied : bool
        False when the limits on the length forbade it.
    child : int
        Number of the child, 0..children - 1.
    index : int
        Waypoint moved, removed, or after which one was added; counted before the change.
    waypoint : int
        The new waypoint, packed; 0 for a deletion and for what was not applied.
    """

    kind: MutationKind
    applied: bool
    child: int
    index: int
    waypoint: int


def clamp(value: int, high: int) -> int:
    """Return ``value`` limited to 0..high."""
    return 0 if value < 0 else min(value, high)


class Mutation:
    """All mutators of the chip."""

    def __init__(self, config: Config) -> None:
        self._config = config

    def mutate(self, children: list[list[int]], draws: Draws, limits: Limits) -> list[Mutated]:
        """Change ``children`` as ``draws`` say, and return what each mutator did.

        The mutators work on different children, so their order does not matter.
        """
        config = self._config
        done = []
        for number, kind in enumerate(config.mutations):
            child = draws.children[number]
            path = children[child]
            index = draws.waypoints[number] * len(path) >> 16
            waypoint = 0
            if kind is MutationKind.DELETE:
                applied = len(path) > config.MIN_WAYPOINTS
                if applied:
                    del path[index]
            else:
                applied = kind is MutationKind.PERTURB or len(path) < config.max_waypoints
                if applied:
                    waypoint = self._moved(path[index], draws.offsets[number], limits)
                    if kind is MutationKind.PERTURB:
                        path[index] = waypoint
                    else:
                        path.insert(index + 1, waypoint)
            done.append(Mutated(kind, applied, child, index, waypoint))
        return done

    def _moved(self, waypoint: int, offset: tuple[int, int, int], limits: Limits) -> int:
        bits = self._config.coordinate_bits
        mask = (1 << bits) - 1
        x = clamp((waypoint & mask) + offset[0], limits.x)
        y = clamp((waypoint >> bits & mask) + offset[1], limits.y)
        altitude = clamp((waypoint >> 2 * bits) + offset[2], limits.altitude)
        return x | y << bits | altitude << 2 * bits
