"""The meaning of an autopilot's parameters for a mission: fences, straight returns, late climbs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pathgene.host.formats.flight_plan import LAND_START, WAYPOINT, FlightPlan
from pathgene.host.mission.autopilot.climbs import SUSTAINED
from pathgene.host.mission.autopilot.mission_lists import ARDUPILOT, PX4
from pathgene.host.mission.autopilot.returns import along, lowest_m, needed_m
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.problem.problem import Problem


__all__ = ["WANTED", "Advice", "advise"]

Floats = NDArray[np.float64]

#: Parameters that matter, by the kind of autopilot; versions differ in their names.
WANTED: Mapping[int, tuple[tuple[str, ...], ...]] = {
    ARDUPILOT: (
        ("FENCE_ENABLE",),
        ("FENCE_TYPE",),
        ("FENCE_ACTION",),
        ("FENCE_ALT_MAX",),
        ("RALLY_LIMIT_KM",),
        ("RTL_ALTITUDE", "ALT_HOLD_RTL"),
        ("RTL_AUTOLAND",),
        ("TECS_CLMB_MAX",),
    ),
    PX4: (
        ("GF_ACTION",),
        ("RTL_RETURN_ALT",),
        ("NAV_FW_ALT_RAD",),
        ("FW_T_ALT_TC",),
        ("FW_T_CLMB_R_SP",),
    ),
}
# Bits of FENCE_TYPE.
_CEILING, _AREAS = 1, 4
# Values of RTL_AUTOLAND: the landing follows a return to home, or serves missed approaches alone.
_HOME_FIRST, _GO_AROUND = 1, 3
# PX4's return mode as an action of its geofence.
_RETURN = 3
# A climb may exceed a limit by this, which is rounding of heights and places.
_SAME_M_S = 0.05
# Gusts make a climb later than the lag of the height does, by up to this factor.
_IN_GUSTS = 2.5
# Mean radius of the Earth.
_EARTH_M = 6_371_009.0
# Places along the mission whose returns are judged are this far apart, metres.
_STEP_M = 200.0


@dataclass(frozen=True)
class Advice:
    """Sentences about parameters, and values that would be better.

    Parameters
    ----------
    sentences : tuple of str
        One about each parameter that does not suit the mission.
    values : mapping
        Values by name, that ``--set-parameters`` sets.
    """

    sentences: tuple[str, ...]
    values: Mapping[str, float]


def advise(
    plan: FlightPlan, found: Mapping[str, float], autopilot: int, problem: Problem | None
) -> Advice:
    """Return the meaning of parameters for a mission.

    Parameters
    ----------
    found : mapping
        Values of :data:`WANTED` by name.
    problem : Problem, optional
        Has the terrain; without it, the return height is not judged.
    """
    if autopilot not in WANTED:
        return Advice((), {})
    if not found:
        return Advice(
            (
                "The autopilot does not give its parameters, so its fences and its return height "
                "are not checked.",
            ),
            {},
        )
    sentences: list[str] = []
    values: dict[str, float] = {}
    if plan.fence:
        _advise_fence(plan, found, sentences, values)
    _advise_waypoints(plan, found, sentences, values)
    _advise_climb(plan, found, sentences)
    if problem is None:
        sentences.append(
            "A .plan file has no terrain, so the return height of the autopilot is not compared "
            "with the ground."
        )
    else:
        _advise_return(plan, found, problem, sentences, values)
    if "RTL_AUTOLAND" in found:
        _advise_landing(plan, int(found["RTL_AUTOLAND"]), sentences, values)
    return Advice(tuple(sentences), values)


def _advise_fence(
    plan: FlightPlan, found: Mapping[str, float], sentences: list[str], values: dict[str, float]
) -> None:
    """Add sentences about fences that do nothing, or that break the mission off."""
    kinds = int(found.get("FENCE_TYPE", _AREAS))
    if not kinds & _AREAS:
        sentences.append(
            f"FENCE_TYPE is {kinds}, so the fences do nothing; {kinds | _AREAS} includes them."
        )
        values["FENCE_TYPE"] = kinds | _AREAS
    highest_m = max((item.alt_m for item in plan.items), default=0.0) - plan.home[2]
    ceiling_m = found.get("FENCE_ALT_MAX", math.inf)
    is_low = bool(kinds & _CEILING) and highest_m > ceiling_m
    if is_low:
        sentences.append(
            f"The mission climbs to {highest_m:.0f} m above home, and FENCE_TYPE and FENCE_ALT_MAX "
            f"limit it to {ceiling_m:g} m: an enabled fence would break the mission off there."
        )
    if found.get("FENCE_ENABLE") == 0:
        sentences.append("FENCE_ENABLE is 0, so the fences do nothing; 1 enables them.")
        if not is_low:
            values["FENCE_ENABLE"] = 1.0
    if found.get("FENCE_ACTION") == 0:
        sentences.append("FENCE_ACTION is 0, so a breach of the fences is only reported.")
    if found.get("GF_ACTION") in (0.0, 1.0):
        sentences.append(
            f"GF_ACTION is {found['GF_ACTION']:g}, so a breach of the fences is at most reported; "
            f"{_RETURN} returns."
        )
        values["GF_ACTION"] = _RETURN


def _advise_waypoints(
    plan: FlightPlan, found: Mapping[str, float], sentences: list[str], values: dict[str, float]
) -> None:
    """Add a sentence about waypoints at whose height a late autopilot has not arrived."""
    if not (found.keys() >= {"NAV_FW_ALT_RAD", "FW_T_ALT_TC"} and found["FW_T_ALT_TC"] > 0):
        return
    reach_m = found["NAV_FW_ALT_RAD"]
    late_m = _late_m(plan, found["FW_T_ALT_TC"])
    if late_m <= reach_m:
        return
    will_do_m = 5.0 * math.ceil(_IN_GUSTS * late_m / 5)
    sentences.append(
        f"NAV_FW_ALT_RAD is {reach_m:g} m, but the heights of this mission are flown up to "
        f"{late_m:.0f} m late, and later in gusts, so the aircraft may circle at waypoints until "
        f"it has their height; {will_do_m:g} m would do."
    )
    # It is the tolerance of the height at which an approach begins, too.
    if all(item.command != LAND_START for item in plan.items):
        values["NAV_FW_ALT_RAD"] = will_do_m


def _advise_landing(
    plan: FlightPlan, value: int, sentences: list[str], values: dict[str, float]
) -> None:
    """Add a sentence about returns of ArduPlane that land, or that keep it from arming."""
    lands = any(item.command == LAND_START for item in plan.items)
    said = f"RTL_AUTOLAND is {value}, "
    if lands and value == 0:
        sentences.append(
            f"{said}so ArduPlane does not arm with a mission that lands; with {_GO_AROUND} it "
            "arms, and a return circles over home as before."
        )
        values["RTL_AUTOLAND"] = _GO_AROUND
    elif lands and value == _HOME_FIRST:
        sentences.append(
            f"{said}so a return continues from home to the landing, on a straight way that is not "
            f"compared with the ground; with {_GO_AROUND} it circles over home."
        )
    elif lands and value != _GO_AROUND:
        sentences.append(
            f"{said}so a return flies straight to the landing instead of home, on a way that is "
            f"not compared with the ground; with {_GO_AROUND} it circles over home."
        )
    elif not lands and value not in (0, _GO_AROUND):
        sentences.append(
            f"{said}but the mission has no landing, so after a return the aircraft circles until "
            "the pilot lands it; to land by itself, it needs a mission with a landing (--land)."
        )


def _advise_climb(plan: FlightPlan, found: Mapping[str, float], sentences: list[str]) -> None:
    """Add a sentence about an autopilot that climbs more slowly than the mission."""
    climb_m_s = max((rise_m / flown_s for rise_m, flown_s in _legs(plan)), default=0.0)
    for name, held in (("TECS_CLMB_MAX", SUSTAINED), ("FW_T_CLMB_R_SP", 1.0)):
        if name in found and held * found[name] < climb_m_s - _SAME_M_S:
            will_do_m_s = math.ceil(10 * climb_m_s / held) / 10
            gusts = f", of which it holds {held:g} in gusts" if held < 1 else ""
            sentences.append(
                f"{name} is {found[name]:g} m/s{gusts}, and the mission climbs at up to "
                f"{climb_m_s:.1f} m/s, so the aircraft falls back below it; {will_do_m_s:g} m/s "
                "would do, if the aircraft climbs so at full throttle."
            )


def _legs(plan: FlightPlan) -> list[tuple[float, float]]:
    """Return the change of height of each leg between waypoints, and its seconds in calm air."""
    points = [item for item in plan.items if item.command == WAYPOINT]
    legs = []
    for a, b in pairwise(points):
        north = math.radians(b.lat - a.lat)
        east = math.radians(b.lon - a.lon) * math.cos(math.radians(a.lat))
        flown_s = _EARTH_M * math.hypot(north, east) / plan.cruise_speed_m_s
        if flown_s:
            legs.append((b.alt_m - a.alt_m, flown_s))
    return legs


def _late_m(plan: FlightPlan, lag_s: float) -> float:
    """Return the maximum error of a late height at the waypoints, in calm air."""
    late_m = worst_m = 0.0
    for rise_m, flown_s in _legs(plan):
        # The error approaches the one that the slope keeps.
        kept_m = lag_s * rise_m / flown_s
        late_m = kept_m + (late_m - kept_m) * math.exp(-flown_s / lag_s)
        worst_m = max(worst_m, abs(late_m))
    return worst_m


def _advise_return(
    plan: FlightPlan,
    found: Mapping[str, float],
    problem: Problem,
    sentences: list[str],
    values: dict[str, float],
) -> None:
    """Add sentences about straight returns to home and to the rally points."""
    name, height_m = _return_height(found)
    if not name:
        return
    way = along(_points(plan, problem), _STEP_M)
    flown_km = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(way[:, :2], axis=0).T)))) / 1000
    # A landing and a start from the ground are lower than returns may be.
    is_high = way[:, 2] >= lowest_m(problem, way[:, 0], way[:, 1]) - 1e-6
    way, flown_km = way[is_high], flown_km[is_high]
    home, rally = _destinations(plan, problem)
    climbs_first = "RTL_RETURN_ALT" in found
    limit_m = 1000 * found.get("RALLY_LIMIT_KM", 0.0) or math.inf
    away = np.hypot(*(way[:, None, :2] - rally[None, :, :2]).T).T if len(rally) else None
    to_home = np.ones(len(way), bool)
    lost = np.zeros(len(way), bool)
    if away is not None:
        nearest, least = away.argmin(axis=1), away.min(axis=1)
        home_m = np.hypot(*(way[:, :2] - home).T)
        to_home = home_m < least if climbs_first else (least > limit_m)
        for number, (x, y, z) in enumerate(rally.tolist()):
            mine = (nearest == number) & ~to_home
            needed = needed_m(problem, way[mine], (x, y), climbs_first=climbs_first)
            at = np.maximum(way[mine, 2], z + (height_m or 0.0)) if climbs_first else z
            lost[mine] = needed > at + 0.01
    if to_home.any():
        needed = needed_m(problem, way[to_home], (home[0], home[1]), climbs_first=climbs_first)
        lost[to_home] = ~np.isfinite(needed)
        # Without a height, the return keeps the altitude at which it begins.
        at = way[to_home, 2] if height_m is None else plan.home[2] + height_m
        at = np.maximum(at, way[to_home, 2]) if climbs_first else at
        is_low = np.isfinite(needed) & (needed > at)
        if is_low.any():
            will_do_m = math.ceil(needed[is_low].max() - plan.home[2])
            unit = "cm" if name == "ALT_HOLD_RTL" else "m"
            sentences.append(
                f"Straight returns to home {_between(flown_km, to_home)} of the mission need "
                f"{will_do_m} m above home, and {name} is {found[name]:g} {unit}."
            )
            values[name] = 100.0 * will_do_m if name == "ALT_HOLD_RTL" else float(will_do_m)
    if lost.any():
        sentences.append(
            f"Straight returns from {100 * lost.mean():.0f} % of the mission "
            f"({_between(flown_km, lost)}) pass too near the ground, through a zone or off the "
            "map, whatever the return height."
        )


def _return_height(found: Mapping[str, float]) -> tuple[str, float | None]:
    """Return the name of the return height, and its metres above home, None for the present one."""
    for name, unit in (("RTL_ALTITUDE", 1.0), ("ALT_HOLD_RTL", 0.01), ("RTL_RETURN_ALT", 1.0)):
        if name in found:
            return name, found[name] * unit if found[name] >= 0 else None
    return "", None


def _between(flown_km: Floats, chosen: NDArray[np.bool_]) -> str:
    """Return the stretch of the mission from the first to the last chosen place."""
    some = flown_km[chosen]
    return f"from km {some[0]:.1f} to {some[-1]:.1f}"


def _points(plan: FlightPlan, problem: Problem) -> list[RoutePoint]:
    """Return the places of a mission in the terrain's frame."""
    items = [item for item in plan.items if (item.lat, item.lon) != (0.0, 0.0)]
    x, y = problem.terrain.to_local(
        np.array([item.lat for item in items]), np.array([item.lon for item in items])
    )
    return [
        RoutePoint(float(east), float(north), item.alt_m, 0)
        for east, north, item in zip(x, y, items, strict=True)
    ]


def _destinations(plan: FlightPlan, problem: Problem) -> tuple[Floats, Floats]:
    """Return the place of home, and places and altitudes of rally points (n, 3)."""
    lat, lon, height = np.array([plan.home, *plan.rally]).T
    x, y = problem.terrain.to_local(lat, lon)
    altitudes = plan.home[2] + height
    places = np.column_stack((x, y, altitudes))
    return places[0, :2], places[1:]
