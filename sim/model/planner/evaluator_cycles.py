"""Cycles of the evaluator of paths, equal to those of the gateware.

The scorer takes a point in every slot of two cycles, entry and exit included. It takes no path
while sixteen are inside. From then on all takes fixed numbers of cycles, but for two queues: that
of the walker, and that of the keys, which leave in the order of the paths. So a few maxima tell the
cycles of a path from those of the paths before it.
"""

from __future__ import annotations

from hdl.config import Config
from sim.model.planner.scorer_cycles import ScorerCycles, freed, launched
from sim.model.planner.walker_cycles import back, walked


__all__ = ["DECISION", "KEY", "PLACES", "QUEUE", "EvaluatorCycles"]

#: Paths that may be inside.
PLACES = 16
#: Cycles from a score to its decision, from there to the offer of the first segment to the walker,
#: and from a decision or the result of a walk to the key.
DECISION, QUEUE, KEY = 1, 3, 3


class EvaluatorCycles:
    """Cycles in which paths pass the evaluator; what takes keys always does.

    Cycles in which ``phase`` is 1, the second of a slot of the scorer, are odd.

    Parameters
    ----------
    config : Config

    Attributes
    ----------
    launcher : int
        First cycle in which the scorer can take the first point of a path.
    free : int
        First cycle in which a path can be launched into the slots of the scorer.
    walker : int
        First cycle in which the walker can launch the first segment of a path.
    """

    def __init__(self, config: Config) -> None:
        self.launcher = self.free = self.walker = 0
        self._back = back(config.lanes, config.memory_latency)
        self._scoring = ScorerCycles.of(config).scored(0, 0)
        self._keys = [-1] * PLACES  # Of the latest paths.
        self._at = 0

    @property
    def room(self) -> int:
        """First cycle in which a place is free for a path."""
        return self._keys[self._at] + 1

    def accept(
        self,
        offered: int,
        points: int,
        is_walked: bool,
        cost: int,
        *,
        has_exit: bool = False,
    ) -> tuple[int, int]:
        """Return the cycle of the key of a path, and the one in which its goal is taken.

        Parameters
        ----------
        offered : int
            Cycle from which the points are offered, without a gap; the head has been accepted
            before.
        points : int
            Points of the path, entry and exit included.
        is_walked : bool
        cost : int
            Sum of the costs of its segments and chords, if it is walked.
        has_exit : bool
            The last point is an exit.
        """
        first = max(offered, self.launcher, self.room)
        launch = launched(first, first + 1, self.free, 0)
        self.free = freed(launch, points)
        goal = launch + 2 * (points - 2 - has_exit)
        self.launcher = goal + 2
        decided = self._scoring + launch + 2 * points + DECISION
        known = decided
        if is_walked:
            self.walker = walked(decided + QUEUE, self.walker, (cost,))
            known = self.walker - 1 + self._back
        key = max(known + KEY, self._keys[self._at - 1] + 1)
        self._keys[self._at] = key
        self._at = (self._at + 1) % PLACES
        return key, goal
