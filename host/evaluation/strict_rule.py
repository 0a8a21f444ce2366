"""The strict rule on paths of one problem: the verdict, and how near each limit is."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import broken, rule_kernels
from pathgene.host.evaluation.constants import VOID_HEIGHT_M, Constants, Floats
from pathgene.host.evaluation.laid_track import LaidTrack
from pathgene.host.evaluation.packed_zones import pack_zones
from pathgene.host.evaluation.terrain_rule import STACK_SHAPE, Required, Surface, excess_m
from pathgene.host.evaluation.zones import zone_intrusions
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain


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
# An end without effect on what is demanded.
_NO_END = (0.0, 0.0, math.inf, 0.0)


class StrictRule:
    """Judges paths of one problem by the strict rule.

    Parameters
    ----------
    problem : Problem
        A problem with rules.
    constants : Constants
        Constants of the kernels for this problem.
    """

    def __init__(self, problem: Problem, constants: Constants) -> None:
        rules = problem.rules
        assert rules is not None
        self._problem, self._rules = problem, rules
        # The rule reads the terrain alone, and never by samples.
        self._constants = constants._replace(sampled=0, roofed=0)
        self._surface = Surface(_ground(problem.terrain), self._constants)
        self._demand = demand = problem.demand
        ends: tuple[float, ...] = ()
        for (x, y, _), height, slope in zip(
            demand.ends, demand.heights_beside_m, demand.slopes, strict=True
        ):
            ends += (x, y, height, slope)
        top = math.inf if rules.ceiling_agl_m is None else rules.ceiling_agl_m
        self._low = Required(1.0, rules.clearance_m, rules.corridor_m, *ends)
        # The demand right below the track, which is greater near the ends.
        self._below = self._low._replace(
            half_width_m=0.0,
            start_height_m=demand.heights_m[0],
            goal_height_m=demand.heights_m[1],
        )
        self._high = Required(-1.0, top, 0.0, *_NO_END, *_NO_END)
        # The negated least height, and the greatest height.
        self._lowest = Required(1.0, 0.0, rules.corridor_m, *_NO_END, *_NO_END)
        self._highest = self._high._replace(height_m=0.0)
        self._zones = pack_zones(problem.zones, rules.zone_margin_m)
        self._timed = pack_zones(problem.zones_at_times, rules.zone_margin_m)
        self._strict = rule_kernels.StrictCourse(
            self._surface, self._low, self._below, self._high, self._zones
        )

    def judge(self, path: Floats) -> tuple[tuple[Any, ...], LaidTrack]:
        """Return the terms of a path, see ``strict_terms``, and its smoothed track."""
        scratch = self._scratch(len(path))
        terms = rule_kernels.strict_terms(path, len(path), self._strict, scratch)
        return terms, LaidTrack(self._constants, len(path), *scratch.path, scratch.times)

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
        results = [
            rule_kernels.strict_penalty(path, n, self._strict, scratch)
            for path, n in zip(paths, lengths.tolist(), strict=True)
        ]
        penalty, cost = np.array(results, dtype=np.float64).reshape(-1, 2).T
        return penalty, cost

    def first_kept(self, paths: Floats, lengths: NDArray[np.int64]) -> int | None:
        """Return the index of the first of paths (m, max_n, 3) without a penalty, or None."""
        scratch = self._scratch(paths.shape[1])
        first = int(rule_kernels.first_kept(paths, lengths, self._strict, scratch))
        return None if first < 0 else first

    def _scratch(self, points: int) -> rule_kernels.StrictScratch:
        return rule_kernels.scratch(points, self._zones)

    def off_demand_m(self, pieces: Floats) -> float:
        """Return the metres of any track too low, too high over the surface, or off the map.

        ``pieces`` is what :func:`pathgene.host.evaluation.laid_pieces.lay_pieces` returns.
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

        Heights are in metres, the least one that within the corridor. A limit is broken where its
        ``worst`` is beyond its ``allowed``; the worst come first.
        """
        lowest = self._extreme(track, self._lowest)
        highest = self._extreme(track, self._highest)
        found = [
            *self._heights(track, lowest, highest),
            *self._zone_distances(track),
            *self._figures(track),
        ]
        limits = [limit for _, limit in sorted(found, key=lambda item: -item[0])]
        return -lowest[0], highest[0], limits

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
        up; the others are exact.
        """
        aircraft, limits = self._problem.aircraft, self._problem.limits
        low, outside = broken.off_demand(self._surface, self._low, self._below, track)
        high: list[broken.Span] = []
        if math.isfinite(self._high.height_m):
            high, _ = broken.off_demand(self._surface, self._high, self._high, track)
        radius = aircraft.turn_radius_m
        turn = "turn" if limits.stall_speed_m_s <= aircraft.cruise_speed_m_s else "stall"
        found: list[tuple[str, Iterable[broken.Span]]] = [
            ("map", outside),
            ("clearance", low),
            ("ceiling-agl", high),
            ("climb", broken.too_steep(track, 1)),
            ("descent", broken.too_steep(track, -1)),
            ("power", broken.too_weak(track, limits.thrust_N)),
            ("fuel", broken.out_of_fuel(track, limits.fuel_N)),
            (turn, broken.impossible_turns(track, radius)),
        ]
        for name, ceiling in (
            ("ceiling", self._rules.ceiling_m),
            ("service-ceiling", aircraft.service_ceiling_m),
        ):
            if ceiling is not None:
                found.append((name, broken.above(track, ceiling)))
        for number, zone in enumerate(self._problem.zones):
            spans = broken.within_zone(track, self._zones, number)
            found.append((f"zone {zone.name or number + 1}", spans))
        stretches = [each for name, spans in found for each in broken.merged(name, spans)]
        return sorted(stretches, key=lambda stretch: stretch.from_m)

    def _heights(self, track: LaidTrack, lowest: _Extreme, highest: _Extreme) -> Iterator[_Scored]:
        excess, at = lowest
        allowed, clearance_m = self._required_m(track, at, beside=True), self._rules.clearance_m
        if allowed == clearance_m:
            # Nowhere is more demanded, so this place has the greatest excess.
            excess += clearance_m
        else:
            excess, at = self._extreme(track, self._low)
            allowed = self._required_m(track, at, beside=True)
        known = max(excess, 0.0)
        excess_below, at_below = self._extreme(track, self._below, known)
        if excess_below > known:
            excess, at = excess_below, at_below
            allowed = self._required_m(track, at, beside=False)
        yield _least("clearance", allowed - excess, allowed, track.flown_m(*at))
        if math.isfinite(self._high.height_m):
            height, at = highest
            yield _most("ceiling-agl", height, self._high.height_m, track.flown_m(*at))
        top, at = track.highest()
        for name, ceiling in (
            ("ceiling", self._rules.ceiling_m),
            ("service-ceiling", self._problem.aircraft.service_ceiling_m),
        ):
            if ceiling is not None:
                yield _most(name, top, ceiling, track.flown_m(*at))

    def _required_m(self, track: LaidTrack, at: tuple[int, float], *, beside: bool) -> float:
        """Return the clearance demanded at a place of the track, metres."""
        x, y = track.place(*at)
        return float(self._demand.required_m(np.array([x]), np.array([y]), beside=beside)[0])

    def _zone_distances(self, track: LaidTrack) -> Iterator[_Scored]:
        """Yield the least distance to each zone, where it applies."""
        intrusions = zone_intrusions(track.pieces, track.rows, track.times, self._zones)
        margin = self._rules.zone_margin_m
        zones = zip(self._problem.zones, intrusions, strict=True)
        for number, (zone, found) in enumerate(zones, 1):
            at = found.entry or found.nearest
            if at is None:
                continue
            # Inside a zone without margin, the distance of 0 is not below the margin.
            worst = -1.0 if found.metres and margin <= found.distance_m else found.distance_m
            yield _least(f"zone {zone.name or number}", worst, margin, at.at_m)

    def _figures(self, track: LaidTrack) -> Iterator[_Scored]:
        """Yield the limits of the aircraft."""
        aircraft, limits = self._problem.aircraft, self._problem.limits
        speed = aircraft.cruise_speed_m_s
        for name, sign, degrees in (
            ("climb", 1, aircraft.max_climb_deg),
            ("descent", -1, aircraft.max_descent_deg),
        ):
            worst, at = track.most(sign, rule_kernels.VERTICAL_SPEED)
            allowed = speed * math.sin(math.radians(degrees))
            yield _most(name, max(worst, 0.0), allowed, track.flown_m(*at))
        if aircraft.engine_power_W is not None:
            worst, at = track.most(1, rule_kernels.THRUST)
            power = max(worst, 0.0) * speed / aircraft.propeller_efficiency
            yield _most("power", power, aircraft.engine_power_W, track.flown_m(*at))
        if aircraft.fuel_weight_N is not None:
            yield _most("fuel", track.fuel, limits.fuel_N, track.length_m)
        radius, at = track.tightest_turn()
        if math.isfinite(radius):
            wind = math.hypot(*self._problem.wind)
            allowed = aircraft.turn_radius_m * (1.0 + wind / speed) ** 2
            yield _least("turn", radius, allowed, track.flown_m(*at))
            if limits.stall_speed_m_s > 0:
                yield _least("stall", speed, limits.stall_speed_m_s, track.flown_m(*at))


# The ground of a terrain as the kernels take it: a changed problem has the same.
_GROUNDS: WeakKeyDictionary[Terrain, Floats] = WeakKeyDictionary()


def _ground(terrain: Terrain) -> Floats:
    """Return the flat raster of a terrain, very high at voids; do not write to it."""
    ground = _GROUNDS.get(terrain)
    if ground is None:
        heights = terrain.elevation
        ground = np.where(np.isnan(heights), VOID_HEIGHT_M, heights).ravel()
        _GROUNDS[terrain] = ground
    return ground


def _least(name: str, worst: float, allowed: float, at_m: float) -> _Scored:
    """Return a limit that values must not be below, and how badly it is broken."""
    return (allowed - worst) / max(abs(allowed), 1.0), _limit(name, worst, allowed, at_m)


def _most(name: str, worst: float, allowed: float, at_m: float) -> _Scored:
    """Return a limit that values must not be above, and how badly it is broken."""
    return (worst - allowed) / max(abs(allowed), 1.0), _limit(name, worst, allowed, at_m)


def _limit(name: str, worst: float, allowed: float, at_m: float) -> Limit:
    return {"limit": name, "worst": worst, "allowed": allowed, "at_m": at_m}
