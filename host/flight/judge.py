"""Verdict on a flight: the ground, the clearance, the zones and the aircraft's limits.

The flight is judged on its own, not by how well it follows its track.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.flight.flight import MARGIN, PERIOD_S, Flown, limits_of
from pathgene.host.flight.ground import demanded_m, is_off_map, known_surface_m
from pathgene.host.flight.guidance import MEAN_S
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import tiles_of
from pathgene.host.problem.zones import Zone


__all__ = ["SHARE", "Verdict", "entered", "judge"]

Floats = NDArray[np.float64]

# Step along the planned track, metres.
_STEP_M = 1.0
#: Share of the clearance that a flight must keep.
SHARE = 0.5


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Promises that a flight kept or broke; the fields are the keys of ``flight.json``.

    Parameters
    ----------
    kept : bool
        The aircraft arrived, kept half of the required clearance everywhere, stayed over known
        ground, and entered no zone.
    breaks : list of str
        A sentence for each broken promise; empty if ``kept``.
    arrived : bool
        The aircraft reached the end of the track.
    interrupted : bool
        The flight was ended early by a signal; all other figures describe the part that was flown.
    flight_time_s, length_m : float
        Time from start to goal, and length of the planned track.
    cross_track_rms_m, cross_track_max_m : float
        Distance to the side of the track: root mean square and maximum.
    height_error_rms_m, height_error_max_m : float
        Vertical distance from the track: root mean square and maximum.
    clearance_asked_m, clearance_planned_m, clearance_flown_m : float
        Clearance that was asked for, minimum of the planned track and minimum of the flight, over
        the surface ``max(nearest node, bilinear)``, where that is known. NaN if no sample has
        known ground below it.
    clearance_share : float
        Minimum share of the required clearance, which is lower near both ends; infinite if none is
        required.
    lowest_at_m : tuple of float
        x, y and horizontal distance along the track of the lowest point.
    zones_entered : list of str
        Names of the zones entered, without their margin.
    airspeed_m_s, power_W : tuple of float
        Minimum and maximum.
    limits : list
        Commands relative to the aircraft's limits, as means over 5 s: ``limit``, ``worst``,
        ``allowed`` and ``excess``, worst / allowed - 1, the largest excess first.
    """

    kept: bool
    breaks: list[str]
    arrived: bool
    interrupted: bool
    flight_time_s: float
    length_m: float
    cross_track_rms_m: float
    cross_track_max_m: float
    height_error_rms_m: float
    height_error_max_m: float
    clearance_asked_m: float
    clearance_planned_m: float
    clearance_flown_m: float
    clearance_share: float
    lowest_at_m: tuple[float, float, float]
    zones_entered: list[str]
    airspeed_m_s: tuple[float, float]
    power_W: tuple[float, float]
    limits: list[dict[str, Any]]

    def to_dict(self) -> dict[str, Any]:
        """The verdict as a dict."""
        return asdict(self)

    @property
    def excess(self) -> float:
        """Largest share by which a command exceeds a limit; negative if none does."""
        return float(self.limits[0]["excess"])


def judge(problem: Problem, track: SmoothedTrack, flown: Flown, aircraft: Aircraft) -> Verdict:
    """Return the verdict on a flight along ``track``.

    Parameters
    ----------
    problem : Problem
        The planned problem: terrain, zones and rules.
    flown : Flown
        The flight, with at least one sample.
    aircraft : Aircraft
        Figures of the aircraft that flew, for its limits.
    """
    clearance = flown.z - known_surface_m(problem.terrain, flown.x, flown.y)
    planned = track.sample(_STEP_M)
    heights = planned.z - known_surface_m(problem.terrain, planned.x, planned.y)
    demanded = demanded_m(problem, flown.x, flown.y)
    asked = problem.rules.clearance_m if problem.rules else 0.0
    lowest = int(np.nanargmin(clearance)) if not np.isnan(clearance).all() else 0
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(demanded > 0, clearance / demanded, math.inf)
    share = float(np.nanmin(np.append(shares, math.inf)))
    names = [
        tiles[0].name or f"zone {number}"
        for number, tiles in enumerate(tiles_of(problem.zones), 1)
        if any(entered(tile, flown).any() for tile in tiles)
    ]
    on_way = np.isfinite(flown.cross_m)
    breaks = []
    if flown.interrupted:
        breaks.append("The flight was interrupted before it reached the goal.")
    elif not flown.arrived:
        breaks.append("The aircraft did not reach the goal.")
    if clearance[lowest] < 0:
        breaks.append(
            f"The flight is {-clearance[lowest]:.1f} m under the ground "
            f"at ({flown.x[lowest]:.0f}, {flown.y[lowest]:.0f})."
        )
    elif share < SHARE:
        worst = int(np.nanargmin(shares))
        breaks.append(
            f"The flight keeps {clearance[worst]:.1f} m of a clearance of {demanded[worst]:.1f} m "
            f"at ({flown.x[worst]:.0f}, {flown.y[worst]:.0f})."
        )
    off_map = is_off_map(problem.terrain, flown.x, flown.y)
    if off_map.any():
        first = int(np.argmax(off_map))
        breaks.append(
            f"The flight leaves the map at ({flown.x[first]:.0f}, {flown.y[first]:.0f}), where the "
            "ground is unknown."
        )
    if np.isnan(clearance[~off_map]).any():
        breaks.append("The flight crosses a void of the terrain.")
    breaks += [f"The flight enters the no-fly zone {name!r}." for name in names]
    return Verdict(
        kept=not breaks,
        breaks=breaks,
        arrived=flown.arrived,
        interrupted=flown.interrupted,
        flight_time_s=float(flown.t_s[on_way][-1]),
        length_m=track.length_m,
        cross_track_rms_m=_rms(flown.cross_m[on_way]),
        cross_track_max_m=float(np.abs(flown.cross_m[on_way]).max()),
        height_error_rms_m=_rms(flown.height_error_m[on_way]),
        height_error_max_m=float(np.abs(flown.height_error_m[on_way]).max()),
        clearance_asked_m=asked,
        clearance_planned_m=float(np.nanmin(np.append(heights, math.inf))),
        clearance_flown_m=float(clearance[lowest]),
        clearance_share=share,
        lowest_at_m=(
            float(flown.x[lowest]),
            float(flown.y[lowest]),
            float(flown.along_m[lowest]),
        ),
        zones_entered=names,
        airspeed_m_s=_range(flown.airspeed_m_s),
        power_W=_range(flown.power_W),
        limits=_limits(aircraft, flown),
    )


def entered(zone: Zone, flown: Flown) -> NDArray[np.bool_]:
    """Return the samples of a flight that lie in a zone while it is active, (k,) bool."""
    inside = zone.footprint.contains(flown.x, flown.y)
    for values, low, high in (
        (flown.z, zone.lower_m, zone.upper_m),
        (flown.t_s, zone.t0_s, zone.t1_s),
    ):
        if low is not None:
            inside &= values >= low
        if high is not None:
            inside &= values <= high
    return inside


def _limits(aircraft: Aircraft, flown: Flown) -> list[dict[str, Any]]:
    most = limits_of(aircraft)
    more = 1 + MARGIN
    rows = [
        ("bank", np.degrees(np.abs(flown.bank_command_rad)), math.degrees(most.bank_rad / more)),
        ("climb", flown.climb_command_m_s, most.climb_m_s / more),
        ("descent", -flown.climb_command_m_s, most.descent_m_s / more),
        ("power", flown.power_W, most.power_W),
    ]
    limits = []
    for name, values, allowed in rows:
        if math.isfinite(allowed):
            worst = float(_means(values).max())
            limits.append(
                {
                    "limit": name,
                    "worst": worst,
                    "allowed": allowed,
                    "excess": worst / allowed - 1,
                }
            )
    return sorted(limits, key=lambda row: -row["excess"])


def _means(values: Floats) -> Floats:
    """Return means over 5 s, or over all samples if there are fewer."""
    count = min(round(MEAN_S / PERIOD_S), len(values))
    sums = np.concatenate(([0.0], np.cumsum(values)))
    means: Floats = (sums[count:] - sums[:-count]) / count
    return means


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _range(values: Sequence[float] | Floats) -> tuple[float, float]:
    return float(np.min(values)), float(np.max(values))
