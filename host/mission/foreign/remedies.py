"""Remedies of faults: the smallest change of a height or place after which a fault is gone."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from pathgene.host.mission.foreign.course import Chain, Handle, Point, moved, without
from pathgene.host.mission.foreign.faults import Fault
from pathgene.host.mission.foreign.judge import Judge
from pathgene.host.terrain import Terrain


__all__ = ["Remedy", "remedies", "remedy"]

_ATTEMPTS = 12
_HALVINGS = 6
_MOST_M = 20_000.0
# Share of a move that moves the worst place, at least, in the first attempts.
_LEAST_SHARE = 0.05
# A fault counts as new if it is worse by this.
_WORSE_M = 0.5
_DIRECTIONS = tuple(
    (math.cos(angle), math.sin(angle)) for angle in (k * math.pi / 4 for k in range(8))
)


@dataclass(frozen=True)
class Remedy:
    """A change after which a fault is gone.

    Parameters
    ----------
    handles : tuple of Handle
        Parts of the mission that change.
    east_m, north_m, up_m : float
        The move, in the terrain's frame.
    is_removal : bool
        The parts are left out.
    breaks : tuple of Fault
        Faults that the change makes.
    """

    handles: tuple[Handle, ...]
    east_m: float = 0.0
    north_m: float = 0.0
    up_m: float = 0.0
    is_removal: bool = False
    breaks: tuple[Fault, ...] = ()

    @property
    def size_m(self) -> float:
        """Sum of the moves."""
        return len(self.handles) * math.hypot(self.east_m, self.north_m, self.up_m)


@dataclass(frozen=True)
class _Way:
    """A direction in which parts may move; the worst place moves by ``share`` of the move."""

    handles: tuple[Handle, ...]
    east: float = 0.0
    north: float = 0.0
    up: float = 0.0
    share: float = 1.0


def remedy(
    judge: Judge, chains: tuple[Chain, ...], fault: Fault, known: Sequence[Fault]
) -> Remedy | None:
    """Return the smallest change that removes a fault, best one that makes no other.

    Parameters
    ----------
    known : sequence of Fault
        All faults of the flight.

    Returns
    -------
    Remedy or None
        None if no change of a height or place near the fault removes it.
    """
    return next(iter(remedies(judge, chains, fault, known)), None)


def remedies(
    judge: Judge, chains: tuple[Chain, ...], fault: Fault, known: Sequence[Fault]
) -> list[Remedy]:
    """Return the changes of :func:`remedy`, the best first."""
    found = [
        each for way in _ways(judge, chains, fault) if (each := _solved(judge, chains, fault, way))
    ]
    if fault.limit == "turn" and not found:
        found = list(_removal(judge, chains, fault))
    checked = [_checked(judge, chains, each, known) for each in found]
    return sorted(checked, key=lambda each: (len(each.breaks) > 0, each.size_m))


def _ways(judge: Judge, chains: tuple[Chain, ...], fault: Fault) -> Iterator[_Way]:
    """Yield the directions that may remove a fault."""
    points = chains[fault.chain].points
    if not fault.is_leg:
        yield from _ways_of_point(judge, points, fault)
        return
    a, b = points[fault.leg], points[fault.leg + 1]
    first, last = _handles(a), _handles(b)
    if fault.limit in ("climb", "descent"):
        # Up first, away from the ground.
        higher, lower = (first, last) if fault.limit == "climb" else (last, first)
        yield from (_Way(each, up=up) for each, up in ((higher, 1.0), (lower, -1.0)) if each)
        return
    for up in _vertical(fault):
        for each, own in ((last, fault.share), (first, 1 - fault.share), ((*first, *last), 1.0)):
            if each:
                yield _Way(each, up=up, share=max(own, _LEAST_SHARE))
    first, last = _placed(a), _placed(b)
    if fault.zone is not None and last and (first or a.is_ground):
        run = math.hypot(b.x_m - a.x_m, b.y_m - a.y_m)
        if run > 0:
            east, north = (a.y_m - b.y_m) / run, (b.x_m - a.x_m) / run
            # A take-off leads from a home that stays.
            share = 1.0 if first else fault.share
            for sign in (1, -1):
                way = _Way((*first, *last), sign * east, sign * north)
                yield replace(way, share=max(share, _LEAST_SHARE))
    if fault.limit == "map":
        for each in filter(None, (last, first, (*first, *last))):
            yield _Way(each, *_inwards(judge.problem.terrain, fault.place))


def _ways_of_point(judge: Judge, points: Sequence[Point], fault: Fault) -> Iterator[_Way]:
    point = points[fault.leg]
    own = _handles(point)
    if not own:
        return
    if fault.limit == "turn":
        if point.circle_m is not None:
            return
        for neighbour in (points[fault.leg - 1], points[fault.leg + 1]):
            away = math.hypot(neighbour.x_m - point.x_m, neighbour.y_m - point.y_m)
            if _handles(neighbour) and away > 0:
                east, north = (neighbour.x_m - point.x_m) / away, (neighbour.y_m - point.y_m) / away
                yield _Way(_handles(neighbour), east, north)
                yield _Way(own, -east, -north)
        return
    yield from (_Way(own, up=up) for up in _vertical(fault))
    if fault.limit == "map" and _placed(point):
        yield _Way(own, *_inwards(judge.problem.terrain, fault.place))
    elif fault.zone is not None and _placed(point):
        yield from (_Way(own, *direction) for direction in _DIRECTIONS)


def _inwards(terrain: Terrain, place: tuple[float, float, float]) -> tuple[float, float]:
    """Return the direction away from the nearest edge of a map, or back over it."""
    x, y, _ = place
    beyond = (
        (-x, (1.0, 0.0)),
        (x - terrain.width_m, (-1.0, 0.0)),
        (-y, (0.0, 1.0)),
        (y - terrain.height_m, (0.0, -1.0)),
    )
    return max(beyond)[1]


def _vertical(fault: Fault) -> tuple[float, ...]:
    """Return the directions up and down that may help."""
    if fault.limit == "clearance":
        return (1.0,)
    if "ceiling" in fault.limit:
        return (-1.0,)
    zone = fault.zone
    if zone is None:
        return ()
    up = (1.0,) if zone.upper_m is not None else ()
    return (*up, -1.0) if zone.lower_m is not None else up


def _handles(point: Point) -> tuple[Handle, ...]:
    """Return the part that states a point, if it may be moved."""
    return () if point.handle is None or point.is_ground else (point.handle,)


def _placed(point: Point) -> tuple[Handle, ...]:
    """Return the part that states the place of a point, if it may be moved."""
    return tuple(handle for handle in _handles(point) if handle[0] != "return")


def _solved(judge: Judge, chains: tuple[Chain, ...], fault: Fault, way: _Way) -> Remedy | None:
    """Return the least move along a way, in whole metres, after which the limit is kept."""
    handles = frozenset(way.handles)
    near = frozenset({(fault.chain, leg) for leg in _legs_at(chains[fault.chain], fault)})

    def left_m(move_m: int) -> float:
        move = (move_m * each for each in (way.east, way.north, way.up))
        after = judge.exact.faults(moved(chains, handles, *move), near)
        return next((each.metres for each in after if each.key == fault.key), 0.0)

    low, high = 0, math.ceil(_first_m(fault, way) - 1e-6)
    for _ in range(_ATTEMPTS):
        if high > _MOST_M:
            return None
        left = left_m(high)
        if not left:
            break
        low, high = high, high + max(math.ceil(left / way.share), 1)
    else:
        return None
    # A return climbs first, and by less than its height grows where it began above it.
    is_linear = fault.limit in ("clearance", "climb", "descent") and ("return", 0) not in handles
    for _ in range(0 if is_linear and not low else _HALVINGS):
        middle = (low + high) // 2
        if middle == low:
            break
        low, high = (middle, high) if left_m(middle) else (low, middle)
    return Remedy(way.handles, high * way.east, high * way.north, high * way.up)


def _first_m(fault: Fault, way: _Way) -> float:
    """Return the first move to try."""
    zone, z = fault.zone, fault.place[2]
    if way.up > 0 and zone is not None and zone.upper_m is not None:
        return max(zone.upper_m + fault.allowed - z, 1.0) / way.share
    if way.up < 0 and zone is not None and zone.lower_m is not None:
        return max(z - zone.lower_m + fault.allowed, 1.0) / way.share
    return fault.metres / way.share


def _legs_at(chain: Chain, fault: Fault) -> Iterator[int]:
    """Yield the legs that a fault depends on."""
    if fault.is_leg or len(chain.points) < 2:
        yield fault.leg
        return
    yield from (leg for leg in (fault.leg - 1, fault.leg) if 0 <= leg < len(chain.points) - 1)


def _removal(judge: Judge, chains: tuple[Chain, ...], fault: Fault) -> Iterator[Remedy]:
    """Yield the removal of the item of a turn that does not fit, if all remaining turns fit."""
    point = chains[fault.chain].points[fault.leg]
    if point.handle is None or point.handle[0] != "item" or point.circle_m is not None:
        return
    left = without(chains, point.handle)
    if len(left) != len(chains):
        return
    legs = range(max(fault.leg - 2, 0), min(fault.leg + 1, len(left[fault.chain].points) - 1))
    after = judge.faults(left, frozenset((fault.chain, leg) for leg in legs))
    if all(each.limit != "turn" for each in after):
        yield Remedy((point.handle,), is_removal=True)


def _checked(
    judge: Judge, chains: tuple[Chain, ...], found: Remedy, known: Sequence[Fault]
) -> Remedy:
    """Return a remedy with the faults that it makes, around the points that it moves."""
    if found.is_removal:
        return found
    handles = frozenset(found.handles)
    near = frozenset(
        (number, leg)
        for number, chain in enumerate(chains)
        for at, point in enumerate(chain.points)
        if point.handle in handles
        for leg in range(max(at - 2, 0), min(at + 2, max(len(chain.points) - 1, 1)))
    )
    before = {each.key: each.metres for each in known}
    after = judge.faults(moved(chains, handles, found.east_m, found.north_m, found.up_m), near)
    breaks = tuple(
        each
        for each in after
        if each.key not in before or each.metres > before[each.key] + _WORSE_M
    )
    return Remedy(found.handles, found.east_m, found.north_m, found.up_m, False, breaks)
