"""The strict rule on paths of one problem: the verdict, and how near each limit is."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import broken, rule_kernels
from pathgene.host.evaluation.aircraft_limits import AIRCRAFT_LIMITS, AircraftLimit
from pathgene.host.evaluation.constants import VOID_HEIGHT_M, Constants, Floats
from pathgene.host.evaluation.laid_track import LaidTrack
from pathgene.host.evaluation.packed_zones import pack_zones
from pathgene.host.evaluation.terrain_rule import STACK_SHAPE, Required, Surface, excess_m
from pathgene.host.evaluation.zones import zone_intrusions
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import numbers_of, wholes
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.surface import ANY_VOID_M


__all__ = ["Limit", "StrictRule"]

#: A limit: its name, the worst value on the path, the value allowed, and the metres flown there.
Limit = dict[str, Any]
_Scored = tuple[float, Limit]
#: A greatest excess, its piece and the share of the piece.
_Extreme = tuple[float, tuple[int, float]]

# The extremes of the report are found to this, metres.
_STEP_M = 0.01
# Below every excess.
_NONE = -1e301
# An end without effect on the required height.
_NO_END = (0.0, 0.0, math.inf, 0.0)


class StrictRule:
    """Judges paths of one problem by the strict rule.

    Parameters
    ----------
    constants : Constants
        Constants of the kernels for this problem.

    Attributes
    ----------
    has_voids : bool
        The terrain has a void.
    """

    def __init__(self, problem: Problem, constants: Constants) -> None:
        rules = problem.rules
        assert rules is not None
        self._problem, self._rules = problem, rules
        # The rule reads only the terrain, and never by samples.
        self._constants = constants._replace(sampled=0, roofed=0)
        ground = _ground(problem.terrain)
        self.has_voids = ground.has_voids
        self._surface = Surface(ground.heights, self._constants)
        self._demand = demand = problem.demand
        ends: tuple[float, ...] = ()
        for (x, y, _), height, slope in zip(
            demand.ends, demand.heights_beside_m, demand.slopes, strict=True
        ):
            ends += (x, y, height, slope)
        top = math.inf if rules.ceiling_agl_m is None else rules.ceiling_agl_m
        self._low = Required(1.0, rules.clearance_m, rules.corridor_m, *ends)
        # The requirement right below the track, which is greater near the ends.
        self._below = self._low._replace(
            half_width_m=0.0,
            start_height_m=demand.heights_m[0],
            goal_height_m=demand.heights_m[1],
        )
        self._high = Required(-1.0, top, 0.0, *_NO_END, *_NO_END)
        # The negated least height, and the greatest height.
        self._lowest = Required(1.0, 0.0, rules.corridor_m, *_NO_END, *_NO_END)
        self._highest = self._high._replace(height_m=0.0)
        self._zones = pack_zones(problem.zones, rules.zone_margin_m, problem.wind)
        # The tiles of a zone have one number.
        self._numbers = numbers_of(problem.zones)
        self._wholes = wholes(problem.zones)
        self._timed = pack_zones(problem.zones_at_times, rules.zone_margin_m, problem.wind)
        self._strict = rule_kernels.StrictCourse(
            self._surface, self._low, self._below, self._high, self._zones
        )
        # The kernels know the compiled limits.
        self._not_compiled = [limit for limit in AIRCRAFT_LIMITS if not limit.is_compiled]

    def judge(self, path: Floats) -> tuple[tuple[Any, ...], LaidTrack]:
        """Return the terms of a path, see ``strict_terms``, and its smoothed track."""
        scratch = self._scratch(len(path))
        terms = rule_kernels.strict_terms(path, len(path), self._strict, scratch)
        track = LaidTrack(self._constants, len(path), *scratch.path, scratch.times)
        *others, beyond = terms
        return (*others, beyond + self._beyond_m(track)), track

    def lay(self, path: Floats) -> LaidTrack:
        """Return the smoothed track of a path with the figures of its pieces."""
        return self.judge(path)[1]

    def add_timed_zones(self, paths: Floats, lengths: NDArray[np.int64], penalty: Floats) -> None:
        """Add the metres of paths in the zones of ``problem.zones_at_times`` to ``penalty``."""
        scratch = self._scratch(paths.shape[1])
        rule_kernels.add_zone_metres(paths, lengths, self._constants, self._timed, scratch, penalty)

    def penalty_cost(self, paths: Floats, lengths: NDArray[np.int64]) -> tuple[Floats, Floats]:
        """Return penalty and cost of paths (m, max_n, 3), (m,) each; infinite for bad paths."""
        scratch = self._scratch(paths.shape[1])
        penalty, cost = np.empty(len(paths)), np.empty(len(paths))
        # One call: each converts some sixty fields of the course.
        rule_kernels.strict_penalties(paths, lengths, self._strict, scratch, penalty, cost)
        if self._not_compiled:
            for i in np.flatnonzero(np.isfinite(penalty)).tolist():
                penalty[i] += self._beyond_m(self.lay(paths[i, : lengths[i]]))
        return penalty, cost

    def first_kept(self, paths: Floats, lengths: NDArray[np.int64]) -> int | None:
        """Return the index of the first of paths (m, max_n, 3) without a penalty, or None."""
        if self._not_compiled:
            kept = np.flatnonzero(self.penalty_cost(paths, lengths)[0] == 0)
            return int(kept[0]) if len(kept) else None
        scratch = self._scratch(paths.shape[1])
        first = int(rule_kernels.first_kept(paths, lengths, self._strict, scratch))
        return None if first < 0 else first

    def _beyond_m(self, track: LaidTrack) -> float:
        """Return the metres of a track beyond the limits that the kernels do not know."""
        return sum(
            stop - start
            for limit in self._not_compiled
            for _, start, stop in broken.merged(limit.name, limit.stretches(self._problem, track))
        )

    def _scratch(self, points: int) -> rule_kernels.StrictScratch:
        return rule_kernels.scratch(points, self._zones)

    def off_demand_m(self, pieces: Floats) -> float:
        """Return the metres of any track too low, too high over the surface, or off the map.

        A track is off the map where its corridor is.

        ``pieces`` come from :func:`pathgene.host.evaluation.laid_track.lay_pieces`.
        """
        stack = np.empty(STACK_SHAPE)
        surface, rows = self._surface, len(pieces)
        metres: float = excess_m(surface, self._low, self._below, pieces, rows, stack)
        if math.isfinite(self._high.height_m):
            metres += excess_m(surface, self._high, self._high, pieces, rows, stack)
        return metres

    def lowest_at_m(self, track: LaidTrack) -> float:
        """Return the metres flown to the least height over the surface within the corridor."""
        return track.flown_m(*self._extreme(track, self._lowest)[1])

    def report(self, track: LaidTrack) -> tuple[float, float, list[Limit]]:
        """Return the least and the greatest height over the surface, and the limits of a track.

        Heights are in metres, the least one that within the corridor. A limit is broken if its
        ``worst`` is beyond its ``allowed``; the worst come first. Over a void the least height is
        NaN, and the worst clearance is minus infinity. If the corridor leaves the map, the least
        height is NaN, too, but the clearance is that over the ground on the map; the limit ``map``
        is the distance between the rim of the corridor and the edge of the map, and it is only
        listed where that is negative.
        """
        lowest = self._extreme(track, self._lowest)
        highest = self._extreme(track, self._highest)
        off_map = list(self._off_map(track))
        found = [
            *off_map,
            *self._heights(track, lowest, highest),
            *self._zone_distances(track),
            *self._figures(track, self._aircraft_limits()[1]),
        ]
        limits = [limit for _, limit in sorted(found, key=lambda item: -item[0])]
        least_m = -lowest[0] if not off_map and lowest[0] < ANY_VOID_M else math.nan
        return least_m, highest[0], limits

    def _off_map(self, track: LaidTrack) -> Iterator[_Scored]:
        """Yield how far the corridor leaves the map, if it does."""
        room_m, row, share = rule_kernels.least_room_on_map(
            self._constants, track.pieces, track.rows, self._rules.corridor_m
        )
        if room_m < 0:
            yield _least("map", room_m, 0.0, track.flown_m(row, share))

    def _extreme(self, track: LaidTrack, required: Required, known: float = _NONE) -> _Extreme:
        """Return the greatest excess over ``required``; ``known`` if none is greater than that."""
        worst, row, share = rule_kernels.extreme_of_track(
            self._surface,
            required,
            track.pieces,
            track.rows,
            known,
            _STEP_M,
            np.empty(rule_kernels.STACK_SHAPE),
        )
        return worst, (row, share)

    def broken(self, track: LaidTrack) -> list[broken.Stretch]:
        """Return the stretches of the track that break a limit, in flying order.

        They are empty exactly for the feasible. A stretch that breaks several limits comes several
        times. Stretches too low or too high are found in parts of ``ds``, a turn that does not fit
        is a turn radius to either side of its waypoint, and fuel is missing from where it is used
        up; all other stretches are exact.
        """
        low, outside = broken.off_demand(self._surface, self._low, self._below, track)
        high: list[broken.Span] = []
        if math.isfinite(self._high.height_m):
            high, _ = broken.off_demand(self._surface, self._high, self._high, track)
        lines, others = self._aircraft_limits()
        found: list[tuple[str, Iterable[broken.Span]]] = [
            ("map", outside),
            ("clearance", low),
            ("ceiling-agl", high),
        ]
        found += [(limit.name, limit.stretches(self._problem, track)) for limit in others]
        if self._rules.ceiling_m is not None:
            found.append(("ceiling", broken.above(track, self._rules.ceiling_m)))
        found += [(limit.name, limit.stretches(self._problem, track)) for limit in lines]
        within: dict[int, list[broken.Span]] = {}
        for row, number in enumerate(self._numbers):
            within.setdefault(number, []).extend(broken.within_zone(track, self._zones, row))
        found += [(self._zone_name(number), spans) for number, spans in within.items()]
        stretches = [each for name, spans in found for each in broken.merged(name, spans)]
        return sorted(stretches, key=lambda stretch: stretch.from_m)

    def entered(self, track: LaidTrack) -> list[Zone]:
        """Return the zones that a track enters, with their margin, while they are active."""
        found = zone_intrusions(track.pieces, track.rows, track.times, self._zones)
        return [
            zone for zone, each in zip(self._problem.zones, found, strict=True) if each.metres > 0
        ]

    def metres_in_zones(self, track: LaidTrack, summed_m: float) -> float:
        """Return the metres of a track inside zones with their margin, each metre once.

        ``summed_m`` is the term of the penalty, which counts a metre in each zone that holds it.
        """
        found = zone_intrusions(track.pieces, track.rows, track.times, self._zones)
        entered = [row for row, each in enumerate(found) if each.metres > 0]
        if len(entered) < 2:
            return summed_m
        spans = [span for row in entered for span in broken.within_zone(track, self._zones, row)]
        return sum(stop - start for _, start, stop in broken.merged("zones", spans))

    def _heights(self, track: LaidTrack, lowest: _Extreme, highest: _Extreme) -> Iterator[_Scored]:
        excess, at = lowest
        allowed, clearance_m = self._required_m(track, at, beside=True), self._rules.clearance_m
        if allowed == clearance_m:
            # No place requires more, so this place has the greatest excess.
            excess += clearance_m
        else:
            excess, at = self._extreme(track, self._low)
            allowed = self._required_m(track, at, beside=True)
        known = max(excess, 0.0)
        excess_below, at_below = self._extreme(track, self._below, known)
        if excess_below > known:
            excess, at = excess_below, at_below
            allowed = self._required_m(track, at, beside=False)
        worst = allowed - excess if excess < ANY_VOID_M else -math.inf
        yield _least("clearance", worst, allowed, track.flown_m(*at))
        if math.isfinite(self._high.height_m):
            height, at = highest
            yield _most("ceiling-agl", height, self._high.height_m, track.flown_m(*at))
        if self._rules.ceiling_m is not None:
            top, at = track.highest()
            yield _most("ceiling", top, self._rules.ceiling_m, track.flown_m(*at))
        yield from self._figures(track, self._aircraft_limits()[0])

    def _aircraft_limits(self) -> tuple[list[AircraftLimit], list[AircraftLimit]]:
        """Return the limits of the aircraft on altitudes, and the remaining ones."""
        lines = [each for each in AIRCRAFT_LIMITS if each.altitude_m(self._problem) is not None]
        return lines, [each for each in AIRCRAFT_LIMITS if each not in lines]

    def _required_m(self, track: LaidTrack, at: tuple[int, float], *, beside: bool) -> float:
        """Return the clearance required at a place of the track, metres."""
        x, y = track.place(*at)
        return float(self._demand.required_m(np.array([x]), np.array([y]), beside=beside)[0])

    def _zone_distances(self, track: LaidTrack) -> Iterator[_Scored]:
        """Yield the minimum distance to each zone within its heights and times."""
        intrusions = zone_intrusions(track.pieces, track.rows, track.times, self._zones)
        margin = self._rules.zone_margin_m
        nearest: dict[int, _Scored] = {}
        for number, found in zip(self._numbers, intrusions, strict=True):
            at = found.entry or found.nearest
            if at is None:
                continue
            # Inside a zone without margin, the distance of 0 is not below the margin.
            worst = -1.0 if found.metres and margin <= found.distance_m else found.distance_m
            scored = _least(self._zone_name(number), worst, margin, at.at_m)
            nearest[number] = max(nearest.get(number, scored), scored, key=lambda each: each[0])
        yield from nearest.values()

    def _zone_name(self, number: int) -> str:
        return f"zone {self._wholes[number - 1].name or number}"

    def _figures(self, track: LaidTrack, limits: Iterable[AircraftLimit]) -> Iterator[_Scored]:
        """Yield limits of the aircraft, where they apply."""
        for limit in limits:
            if (worst := limit.worst(self._problem, track)) is not None:
                scored = _least if limit.is_minimum else _most
                yield scored(limit.name, worst.value, worst.allowed, worst.at_m)


class _Ground(NamedTuple):
    """The flat raster of a terrain, very high at voids, and whether there is a void."""

    heights: Floats
    has_voids: bool


# The ground of a terrain as the kernels take it: a changed problem has the same.
_GROUNDS: WeakKeyDictionary[Terrain, _Ground] = WeakKeyDictionary()


def _ground(terrain: Terrain) -> _Ground:
    """Return the ground of a terrain; do not write to it."""
    ground = _GROUNDS.get(terrain)
    if ground is None:
        voids = terrain.voids
        heights = np.where(voids, VOID_HEIGHT_M, terrain.elevation).ravel()
        ground = _GROUNDS[terrain] = _Ground(heights, bool(voids.any()))
    return ground


def _least(name: str, worst: float, allowed: float, at_m: float) -> _Scored:
    """Return a limit that values must not be below, and how badly it is broken."""
    return (allowed - worst) / max(abs(allowed), 1.0), _limit(name, worst, allowed, at_m)


def _most(name: str, worst: float, allowed: float, at_m: float) -> _Scored:
    """Return a limit that values must not be above, and how badly it is broken."""
    return (worst - allowed) / max(abs(allowed), 1.0), _limit(name, worst, allowed, at_m)


def _limit(name: str, worst: float, allowed: float, at_m: float) -> Limit:
    return {"limit": name, "worst": worst, "allowed": allowed, "at_m": at_m}
