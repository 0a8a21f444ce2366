"""Repairs of a fault: changed missions in which it may be gone, with the metres of the change."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property

import numpy as np

from pathgene.host.errors import PathgeneError
from pathgene.host.formats.mission_items import AMSL, MissionItem
from pathgene.host.mission.foreign.check import MissionCheck
from pathgene.host.mission.foreign.commands import FRAMES, Command, Frame
from pathgene.host.mission.foreign.course import Chain, Handle, Point
from pathgene.host.mission.foreign.draft import Draft
from pathgene.host.mission.foreign.home import Surroundings
from pathgene.host.mission.foreign.remedies import Remedy, remedies
from pathgene.host.problem.problem import Problem


__all__ = ["Means", "Place", "Repair", "Repairs"]

#: x, y and altitude in the terrain's frame.
Place = tuple[float, float, float]

# Distance beside a leg that is tried at most, its growth, and the halvings afterwards.
_MOST_BESIDE_M = 6000.0
_GROWTH = 1.4
_HALVINGS = 5
# Directions in which an item leaves a zone, and how far beyond its margin.
_DIRECTIONS = 72
_BEYOND_M = 2.0
# Attempts to raise a waypoint above a leg.
_RAISES = 4
_FLOWN = frozenset(Command) - {Command.DO_JUMP, Command.DO_CHANGE_SPEED, Command.DO_LAND_START}
# An inserted waypoint keeps this share of a leg to its ends.
_LEAST_SHARE = 0.02


class Means(IntEnum):
    """Kinds of changes, in the order in which they are tried."""

    HEIGHTS = 0
    WAYPOINTS = 1
    DETOURS = 2
    REMOVALS = 3


@dataclass(frozen=True)
class Repair:
    """A changed mission.

    Parameters
    ----------
    draft : Draft
        The mission.
    metres : float
        Sum of the moves, or length of the deviation.
    """

    draft: Draft
    metres: float


class Repairs:
    """Repairs of the first fault of a mission.

    Lines of a survey keep their places. The height of a return is no part of a file, so it is never
    changed.

    Parameters
    ----------
    check : MissionCheck
        The check of the draft; it has a fault.
    ways : dict, optional
        Memory of the planner's ways, which repairs of similar drafts share.
    """

    def __init__(
        self,
        draft: Draft,
        check: MissionCheck,
        ways: dict[tuple[object, ...], list[Place]] | None = None,
    ) -> None:
        self._ways = {} if ways is None else ways
        self.draft, self.check, self.fault = draft, check, check.faults[0]
        self.judge, self.chains = check.judge, check.flight.chains
        self.terrain = check.judge.problem.terrain
        self.chain = self.chains[self.fault.chain]
        self.index = {entry.item.number: at for at, entry in enumerate(draft.written)}
        self.around = Surroundings(draft.file, self.terrain)

    def by(self, means: Means) -> Iterator[Repair]:
        """Yield the repairs by one kind of change."""
        if means is Means.HEIGHTS:
            yield from self.heights()
        elif means is Means.WAYPOINTS:
            yield from self.waypoints()
        elif means is Means.DETOURS:
            yield from self.detours()
        else:
            yield from self.removals()

    @cached_property
    def _remedies(self) -> list[Remedy]:
        return remedies(self.judge, self.chains, self.fault, self.check.faults)

    def heights(self) -> Iterator[Repair]:
        """Yield changes of heights; of a turn, the moves and the radius that make it fit."""
        point, last = self.chain.points[self.fault.leg], self.chain.points[-1]
        if self.fault.limit == "clearance" and last.is_ground and last.handle:
            up_m = self.around.ground(last.x_m, last.y_m) - last.z_m
            if up_m > 0:
                yield Repair(self.draft.raised([self.index[last.handle[1]]], [], up_m), up_m)
        if self.fault.limit == "turn" and point.circle_m and point.asked_m and point.handle:
            radius_m = math.ceil(point.circle_m)
            draft = self.draft.widened(self.index[point.handle[1]], radius_m)
            yield Repair(draft, radius_m - point.asked_m)
        for found in self._remedies:
            is_turn = self.fault.limit == "turn"
            if any(handle[0] == "return" for handle in found.handles):
                continue
            if found.up_m:
                yield self._raised(found)
            elif is_turn and not found.is_removal:
                yield from self._moved(found)

    def waypoints(self) -> Iterator[Repair]:
        """Yield inserted waypoints on and beside the leg, and moves out of zones."""
        if self.fault.is_leg and self.fault.limit == "clearance":
            yield from self._over()
        if self.fault.is_leg and self.fault.limit not in ("climb", "descent"):
            yield from self._beside()
        for found in self._remedies:
            if not (found.up_m or found.is_removal):
                yield from self._moved(found)
        if self.fault.zone is not None:
            yield from self._out_of_zone()

    def detours(self) -> Iterator[Repair]:
        """Yield the way of a planner between the ends of the leg, or of a leg at the turn."""
        at, points = self.fault.leg, self.chain.points
        legs = [at]
        if not self.fault.is_leg:
            legs = [at, at - 1] if self.fault.limit == "turn" else []
        for leg in legs:
            ends = points[leg : leg + 2] if leg >= 0 else ()
            if len(ends) < 2 or any(each.is_ground for each in ends) or not self._may_insert(leg):
                continue
            path = self._planned(leg)
            if path:
                yield from self._inserted(leg, path)

    def removals(self) -> Iterator[Repair]:
        """Yield the mission without the item of a turn, unless it belongs to a survey."""
        for found in self._remedies:
            if not found.is_removal:
                continue
            at = self.index[found.handles[0][1]]
            if not self.draft.entries[at].item.within:
                here, before = (self.chain.points[self.fault.leg - back] for back in (0, 1))
                yield Repair(self.draft.removed(at), math.dist(here.place, before.place))

    def _raised(self, found: Remedy) -> Repair:
        items = [self.index[number] for kind, number in found.handles if kind == "item"]
        rally = [number - 1 for kind, number in found.handles if kind == "rally"]
        draft = self.draft.raised(sorted(set(items)), sorted(set(rally)), found.up_m)
        return Repair(draft, found.size_m)

    def _moved(self, found: Remedy) -> Iterator[Repair]:
        """Yield a move, unless it would move a survey or an item without a place."""
        move = dict.fromkeys(found.handles, (found.east_m, found.north_m))
        repaired = self._placed(move)
        if repaired is not None:
            yield Repair(repaired, found.size_m)

    def _placed(self, move: dict[Handle, tuple[float, float]]) -> Draft | None:
        places, heights, rally = {}, {}, {}
        known = {point.handle: point for chain in self.chains for point in chain.points}
        for handle, (east_m, north_m) in move.items():
            point = known[handle]
            x, y = point.x_m + east_m, point.y_m + north_m
            lat, lon = map(float, self.terrain.to_geographic(x, y))
            if handle[0] == "rally":
                rally[handle[1] - 1] = lat, lon
                continue
            at = self.index[handle[1]]
            item = self.draft.entries[at].item
            if item.within or item.lat is None or item.frame not in FRAMES:
                return None
            places[at] = lat, lon
            if FRAMES[item.frame] is Frame.GROUND:
                heights[at] = self.around.height_in(item.frame, x, y, point.z_m)
                if math.isnan(heights[at]):
                    return None
        return self.draft.placed(places, heights, rally)

    def _over(self) -> Iterator[Repair]:
        """Yield a waypoint on the line, above the worst place."""
        fault = self.fault
        if not _LEAST_SHARE < fault.share < 1 - _LEAST_SHARE:
            return
        if not self._may_insert(fault.leg, on_line=True):
            return
        a, b = self.chain.points[fault.leg : fault.leg + 2]
        x, y = (p + fault.share * (q - p) for p, q in ((a.x_m, b.x_m), (a.y_m, b.y_m)))
        up = math.ceil(fault.metres)
        for _ in range(_RAISES):
            path = [(x, y, fault.place[2] + up)]
            left_m = self._left_m(fault.leg, path)
            if not left_m:
                break
            up += math.ceil(left_m)
        yield from self._inserted(fault.leg, path, up)

    def _beside(self) -> Iterator[Repair]:
        """Yield one waypoint, or two, to the left and to the right of the leg."""
        leg = self.fault.leg
        a, b = self.chain.points[leg : leg + 2]
        run = math.hypot(b.x_m - a.x_m, b.y_m - a.y_m)
        if a.is_ground or run <= 0 or not self._may_insert(leg):
            return
        shares = (self.fault.share,)
        first, last = (each / run for each in self.fault.span_m)
        margin = self.judge.radius_m / run
        pair = max(first - margin, 0.1), min(last + margin, 0.9)
        for side, wanted in itertools.product((1.0, -1.0), (shares, pair)):
            shared = [min(max(share, 0.1), 0.9) for share in wanted]
            found = self._nearest_beside(leg, side, shared)
            if found is not None:
                path, offset = found
                yield from self._inserted(leg, path, offset * len(path))

    def _nearest_beside(
        self, leg: int, side: float, shares: Sequence[float]
    ) -> tuple[list[Place], float] | None:
        """Return the waypoints nearest to the leg with which the fault is gone."""
        a, b = self.chain.points[leg : leg + 2]
        run = math.hypot(b.x_m - a.x_m, b.y_m - a.y_m)
        east, north = (b.y_m - a.y_m) / run * side, (a.x_m - b.x_m) / run * side

        def path(offset: float) -> list[Place]:
            return [
                (
                    a.x_m + share * (b.x_m - a.x_m) + offset * east,
                    a.y_m + share * (b.y_m - a.y_m) + offset * north,
                    a.z_m + share * (b.z_m - a.z_m),
                )
                for share in shares
            ]

        low, high = 0.0, max(self.fault.metres, 10.0)
        while not self._clears(leg, path(high)):
            low, high = high, high * _GROWTH
            if high > _MOST_BESIDE_M:
                return None
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            low, high = (low, middle) if self._clears(leg, path(middle)) else (middle, high)
        high = math.ceil(high)
        return path(high), high

    def _with(self, leg: int, path: Sequence[Place]) -> list[Chain]:
        """Return the flight with waypoints on a leg."""
        points = self.chain.points
        new = [Point(*place, "new") for place in path]
        chains = list(self.chains)
        chains[self.fault.chain] = replace(
            self.chain, points=(*points[: leg + 1], *new, *points[leg + 1 :])
        )
        return chains

    def _left_m(self, leg: int, path: Sequence[Place]) -> float:
        """Return the metres by which the limit of the fault is broken, with waypoints on a leg."""
        near = frozenset((self.fault.chain, leg + at) for at in range(len(path) + 1))
        found = self.judge.exact.faults(self._with(leg, path), near)
        own = (each.metres for each in found if each.is_leg and each.limit == self.fault.limit)
        return max(own, default=0.0)

    def _clears(self, leg: int, path: Sequence[Place]) -> bool:
        """Return whether the limit is kept, and no turn too tight, with waypoints on a leg."""
        chains = self._with(leg, path)
        last = min(leg + len(path) + 1, len(chains[self.fault.chain].points) - 2)
        near = frozenset((self.fault.chain, at) for at in range(max(leg - 1, 0), last + 1))
        own = range(max(leg - 1, 0), leg + 3)
        known = {
            each.limit
            for each in self.check.faults
            if each.chain == self.fault.chain and each.leg in own
        } - {self.fault.limit}
        is_clear = all(
            fault.limit in known
            for fault in self.judge.faults(chains, near)
            if fault.limit in ("turn", "map", "void", self.fault.limit) or fault.zone is not None
        )
        return is_clear and not self._left_m(leg, path)

    def _out_of_zone(self) -> Iterator[Repair]:
        """Yield the move of each end in the zone to the nearest place outside it."""
        zone, fault = self.fault.zone, self.fault
        assert zone is not None
        angles = np.linspace(0, 2 * np.pi, _DIRECTIONS, endpoint=False)
        points = self.chain.points[fault.leg : fault.leg + (2 if fault.is_leg else 1)]
        for point in points:
            if point.handle is None or point.is_ground or point.handle[0] == "return":
                continue
            needed = fault.allowed + (point.circle_m or 0.0) + _BEYOND_M
            if float(zone.footprint.distance_m(np.array([point.x_m]), np.array([point.y_m]))[0]) > (
                needed
            ):
                continue
            for away in np.arange(10.0, _MOST_BESIDE_M, 10.0):
                x, y = point.x_m + away * np.sin(angles), point.y_m + away * np.cos(angles)
                distance = zone.footprint.distance_m(x, y)
                best = int(np.argmax(distance))
                if distance[best] >= needed:
                    move = float(x[best] - point.x_m), float(y[best] - point.y_m)
                    draft = self._placed({point.handle: move})
                    if draft is not None:
                        yield Repair(draft, float(away))
                    break

    def _planned(self, leg: int) -> list[Place]:
        """Return the waypoints of a planner's way between the ends of a leg."""
        problem, points = self.judge.problem, self.chain.points
        a, b = points[leg : leg + 2]
        before = None if a.is_free else _heading(points, leg - 1, problem)
        after = None if b.is_free else _heading(points, leg + 1, problem)
        asked = a.place, b.place, before, after
        if asked not in self._ways:
            self._ways[asked] = self._searched(a, b, before, after)
        return self._ways[asked]

    def _searched(
        self, a: Point, b: Point, before: float | None, after: float | None
    ) -> list[Place]:
        """Return the waypoints of a way with headings at its ends, or none."""
        from pathgene.host.evaluation import Evaluator
        from pathgene.host.planners.base import Options
        from pathgene.host.planners.grid.astar import AstarPlanner

        problem = self.judge.problem
        try:
            task = Problem(
                problem.terrain,
                a.place,
                b.place,
                problem.aircraft,
                problem.zones,
                problem.wind,
                rules=problem.rules,
                start_heading_deg=before,
                goal_heading_deg=after,
            )
            result = AstarPlanner().plan(Evaluator(task), Options())
        except PathgeneError:
            return []
        if result.path is None:
            return []
        return [(x, y, z) for x, y, z in result.path[1:-1].tolist()]

    def _may_insert(self, leg: int, *, on_line: bool = False) -> bool:
        """Return whether a leg may get waypoints; a line of a survey gets them on it only."""
        return self._gap(leg) is not None and (on_line or not self._is_line(leg))

    def _is_line(self, leg: int) -> bool:
        """Return whether both ends of a leg belong to a survey or corridor."""
        within = [self._item(point) for point in self.chain.points[leg : leg + 2]]
        names = {item.within if item is not None else "" for item in within}
        return len(names) == 1 and names != {""}

    def _item(self, point: Point) -> MissionItem | None:
        if point.handle is None or point.handle[0] != "item":
            return None
        return self.draft.entries[self.index[point.handle[1]]].item

    def _gap(self, leg: int) -> int | None:
        """Return the index of the entry before which waypoints of a leg are inserted."""
        a, b = self.chain.points[leg : leg + 2]
        if a.handle is None or a.handle[0] != "item":
            return None
        begin = self.index[a.handle[1]]
        commands = [entry.item.command for entry in self.draft.entries]
        if b.handle is None or b.handle[0] != "item":
            return _first(commands, Command.RETURN_TO_LAUNCH, begin)
        end = self.index[b.handle[1]]
        between = commands[begin + 1 : end]
        jumps = Command.DO_JUMP in between and any(each in _FLOWN for each in between)
        if end > begin and not jumps:
            return end
        return _first(commands, Command.DO_JUMP, begin)

    def _inserted(
        self, leg: int, path: Sequence[Place], metres: float | None = None
    ) -> Iterator[Repair]:
        """Yield the mission with waypoints on a leg."""
        at = self._gap(leg)
        a, b = self.chain.points[leg : leg + 2]
        if at is None:
            return
        pattern, origin = self._item(b) or self._item(a), self._item(a)
        frame = pattern.frame if pattern is not None and pattern.frame in FRAMES else AMSL
        within = origin.within if origin is not None and self._is_line(leg) else ""
        radius, yaw = 0.0, None
        if origin is not None and origin.command == Command.WAYPOINT:
            radius, yaw = origin.params[1] or 0.0, origin.params[3]
        items = []
        for x, y, z in path:
            lat, lon = map(float, self.terrain.to_geographic(x, y))
            height = self.around.height_in(frame, x, y, z)
            if math.isnan(height):
                return
            params = (0.0, radius, 0.0, yaw)
            items.append(MissionItem(0, Command.WAYPOINT, frame, params, lat, lon, height, within))
        if metres is None:
            places = [a.place, *path, b.place]
            longer = sum(math.dist(*pair) for pair in itertools.pairwise(places))
            metres = longer - math.dist(a.place, b.place)
        yield Repair(self.draft.inserted(at, items), metres)


def _first(commands: Sequence[int], command: Command, after: int) -> int | None:
    return next((at for at in range(after + 1, len(commands)) if commands[at] == command), None)


def _heading(points: Sequence[Point], leg: int, problem: Problem) -> float | None:
    """Return the true heading along a leg, or None if there is no such leg."""
    if not 0 <= leg < len(points) - 1:
        return None
    a, b = points[leg : leg + 2]
    if math.hypot(b.x_m - a.x_m, b.y_m - a.y_m) == 0:
        return None
    return (math.degrees(math.atan2(b.x_m - a.x_m, b.y_m - a.y_m)) + problem.north_deg) % 360
