"""Evaluation of a path: score, then walk, then key."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import HIT_BITS, VALUE_BITS, PathClass, ProblemRecord
from pathgene.sim.model.planner.definition.memo import Memo
from pathgene.sim.model.planner.definition.score import corner_of, score
from pathgene.sim.model.planner.definition.walk import Ground, Point, walk
from pathgene.sim.model.planner.walker_cycles import cost


__all__ = ["NO_LIMIT", "Evaluator", "key_of"]

#: A key above all others: no path is given up.
NO_LIMIT = 4 << VALUE_BITS
#: Greatest value of a key.
_TOP = (1 << VALUE_BITS) - 1


@dataclass
class Evaluator:
    """Scorer, walker and memo over one map.

    Attributes
    ----------
    walk : int
        Cycles of the walker.
    """

    config: Config
    record: ProblemRecord
    ground: Ground
    memo: Memo
    walk: int = 0
    ends: tuple[Point, Point] = field(init=False)

    def __post_init__(self) -> None:
        self.ends = corner_of(self.record, "start"), corner_of(self.record, "goal")

    def evaluate(
        self, path: Sequence[Point], margins: list[int], limit: int, *, first: bool
    ) -> int:
        """Return the key of ``path``, ends included.

        With ``first``, the best path is feasible: a path that is infeasible by its score, or whose
        value is not below ``limit``, is not walked, and ``margins`` stay. Other paths are walked to
        their end, but with ``first`` no collision counts behind the first segment or chord that
        collides. ``margins``, one for each point, get at each waypoint the least margin of its two
        segments and its chord.
        """
        has_entry, has_exit = self.record.has_entry, self.record.has_exit
        scored = score(self.record, path)
        value = min(max(scored.cost >> self.record.key_shift, 0), _TOP)
        if first and scored.penalty:
            return key_of(PathClass.INFEASIBLE, scored.penalty)
        if first and value >= limit:
            return key_of(PathClass.GIVEN_UP, value)

        arcs = [*[None] * (1 - has_entry), *scored.arcs, *[None] * (1 - has_exit)]
        hits, before, counts = 0, self.config.blocked_altitude, True
        for i, arc in enumerate(arcs):
            if i:
                found, margin = self.segment(path[i - 1], path[i])
                hits += found if counts else 0
                margins[i - 1] = min(before, margin)
                before = margin
                counts &= not (first and found)
            if arc is not None and arc.chord is not None:
                found, margin = self.segment(*arc.chord)
                hits += found if counts else 0
                before = min(before, margin)
                counts &= not (first and found)
        if hits or scored.penalty:
            units = hits << HIT_BITS
            return key_of(PathClass.INFEASIBLE, scored.penalty + units)
        return key_of(PathClass.FEASIBLE, value)

    def segment(self, start: Point, stop: Point) -> tuple[int, int]:
        """Return hits and margin of a segment, from the memo or by a walk."""
        known = self.memo.get(start, stop)
        self.walk += cost(start, stop, known is not None, self.config.lanes)
        if known is not None:
            return known
        walked = walk(self.ground, self.config.blocked_altitude, start, stop)
        self.memo.put(start, stop, walked)
        return walked


def key_of(path_class: PathClass, value: int) -> int:
    """Return a key: the class above the value, which ends at its greatest and at 0."""
    return path_class << VALUE_BITS | min(max(value, 0), _TOP)
