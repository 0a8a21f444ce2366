"""Verdict on a flight with replans, based only on the flight and the zones at each moment."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.flight.flight import PERIOD_S
from pathgene.host.flight.ground import demanded_m, is_off_map, known_surface_m
from pathgene.host.flight.judge import SHARE
from pathgene.host.problem.tiles import tiles_of
from pathgene.host.problem.zones import Zone
from pathgene.host.replanning.session import Session
from pathgene.host.report.summary import finite, version


__all__ = ["WAY_OUT_SHARE", "Outcome", "Replanned", "judge"]


Floats = NDArray[np.float64]

#: A zone that appears over the aircraft must be left within this multiple of the shortest way out.
WAY_OUT_SHARE = 1.1
# Slack of the route out, in metres: flight between two guidance updates, and the reaction.
_WAY_OUT_SLACK_M = 10.0


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Verdict on a flight with replans.

    Parameters
    ----------
    ended : str
        ``arrived``, ``holding`` (on a safe circle without a path to the goal), ``crashed``,
        ``lost`` or ``interrupted``.
    interrupted : bool
        The flight was ended early by a signal; all other figures describe the part that was flown.
    alive : bool
        The aircraft touched neither ground nor zone, and was not lost.
    kept : bool
        The aircraft is alive, arrived, kept half of the required clearance everywhere, and stayed
        on the map.
    flight_time_s : float
        From the start of the path to the end.
    clearance_flown_m : float
        Minimum height over the surface, where that is known.
    clearance_share : float
        Minimum share of the required clearance; infinite if none is required.
    zone_distance_m : float
        Minimum distance from a zone, ignoring its margin and zones that appeared over the aircraft;
        infinite without zones.
    cross_track_max_m : float
        Maximum lateral distance of the flight from its track.
    ready_share : float
        Share of the searches that found a safe circle within reach.
    """

    ended: str
    interrupted: bool
    alive: bool
    kept: bool
    breaks: list[str]
    flight_time_s: float
    clearance_flown_m: float
    clearance_share: float
    zone_distance_m: float
    cross_track_max_m: float
    ready_share: float

    def to_dict(self) -> dict[str, Any]:
        """The outcome as a dict."""
        return asdict(self)


def judge(session: Session) -> Outcome:
    """Return the verdict on a flight; a flight that did not end by itself was interrupted."""
    problem = session.mission
    flown = np.array(session.pilot.samples, dtype=np.float64)
    x, y, z = flown[:, 1], flown[:, 2], flown[:, 3]
    clearance = z - known_surface_m(problem.terrain, x, y)
    demanded = demanded_m(problem, x, y)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(demanded > 0, clearance / demanded, math.inf)
    lowest = int(np.nanargmin(clearance))
    share = float(np.nanmin(shares))
    touched = []
    if session.ended == "lost":
        touched.append(
            "The aircraft is lost: it cannot follow its track, or found neither path nor circle."
        )
    if clearance[lowest] < 0:
        touched.append(
            f"The flight is {-clearance[lowest]:.1f} m under the ground at "
            f"({x[lowest]:.0f}, {y[lowest]:.0f}) after {PERIOD_S * lowest:.0f} s."
        )
    in_zones, distance = _zones(session, flown)
    touched += in_zones
    breaks = list(touched)
    if not session.ended:
        breaks.append("The flight was interrupted before it reached the goal.")
    if session.ended == "holding":
        breaks.append("The aircraft waits on a safe circle: no path to the goal was found.")
    if 0 <= share < SHARE:
        worst = int(np.nanargmin(shares))
        breaks.append(
            f"The flight keeps {clearance[worst]:.1f} m of a clearance of {demanded[worst]:.1f} m "
            f"at ({x[worst]:.0f}, {y[worst]:.0f})."
        )
    off_map = is_off_map(problem.terrain, x, y)
    if off_map.any():
        first = int(np.argmax(off_map))
        breaks.append(
            f"The flight leaves the map at ({x[first]:.0f}, {y[first]:.0f}), where the ground is "
            "unknown."
        )
    return Outcome(
        ended=session.ended or "interrupted",
        interrupted=not session.ended,
        alive=not touched,
        kept=not breaks,
        breaks=breaks,
        flight_time_s=session.pilot.time_s,
        clearance_flown_m=float(clearance[lowest]),
        clearance_share=share,
        zone_distance_m=distance,
        cross_track_max_m=float(np.abs(flown[:, 5]).max()),
        ready_share=session.ready_share,
    )


def _zones(session: Session, flown: Floats) -> tuple[list[str], float]:
    """Return sentences about zones entered, and the minimum distance from all other zones."""
    seconds: Floats = np.arange(len(flown), dtype=np.float64) * PERIOD_S
    past = session.airspace.past
    ends = [since for since, _ in past[1:]] + [math.inf]
    breaks, least = [], math.inf
    entered_before: set[str] = set()
    for (since, zones), end in zip(past, ends, strict=True):
        during = np.flatnonzero((seconds >= since) & (seconds < end))
        if not len(during):
            continue
        entered_now: set[str] = set()
        for number, tiles in enumerate(tiles_of(zones), 1):
            name = tiles[0].name or f"zone {number}"
            distances = np.min(
                [_active_distance_m(tile, flown[during], seconds[during]) for tile in tiles], axis=0
            )
            inside = distances < 0
            if inside[0] and (name in entered_before or _appears(session, since)):
                out = int(np.argmin(inside)) if not inside.all() else len(inside)
                steps = np.hypot(*np.diff(flown[during[: out + 1], 1:3], axis=0).T)
                way_m, shortest_m = float(steps.sum()), _shortest_m(session, since)
                if way_m > WAY_OUT_SHARE * shortest_m + _WAY_OUT_SLACK_M:
                    breaks.append(
                        f"The zone {name!r} is left after {way_m:.0f} m, where the shortest way "
                        f"out is {shortest_m:.0f} m."
                    )
                if out == len(inside):
                    entered_now.add(name)
                # The distance says nothing about a zone that appeared over the aircraft.
                inside, distances = inside[out:], distances[:0]
            if inside.any():
                first = during[len(during) - len(inside) + int(np.argmax(inside))]
                breaks.append(
                    f"The flight enters the no-fly zone {name!r} after {seconds[first]:.0f} s."
                )
            if len(distances):
                least = min(least, float(distances.min()))
        entered_before = entered_now
    return breaks, least


def _appears(session: Session, since_s: float) -> bool:
    """Return whether zones were new at the time of a change."""
    return any(abs(change.at_s - since_s) < PERIOD_S for change in session.changes)


def _shortest_m(session: Session, since_s: float) -> float:
    """Return the length of the shortest route out of the zones at the time of a change, metres."""
    return max(
        (change.inside_m for change in session.changes if abs(change.at_s - since_s) < PERIOD_S),
        default=0.0,
    )


def _active_distance_m(zone: Zone, flown: Floats, seconds: Floats) -> Floats:
    """Return the distances of samples from a zone; infinite while it does not apply."""
    distance = zone.footprint.distance_m(flown[:, 1], flown[:, 2])
    for values, low, high in (
        (flown[:, 3], zone.lower_m, zone.upper_m),
        (seconds, zone.t0_s, zone.t1_s),
    ):
        if low is not None:
            distance = np.where(values >= low, distance, math.inf)
        if high is not None:
            distance = np.where(values <= high, distance, math.inf)
    return distance


# Seconds between two points of the flight in the file, and digits of its columns.
_POINT_S = 1.0
_COLUMNS = {"x": 2, "y": 2, "z": 2}


@dataclass(frozen=True, eq=False)
class Replanned:
    """A flight with replans, and its outcome.

    Parameters
    ----------
    constant_s : float
        Processor share of a plan, seconds.
    """

    session: Session
    outcome: Outcome
    planner: str
    board: str | None
    constant_s: float

    def to_dict(self) -> dict[str, Any]:
        """The content of ``flight.json``; every number is finite or None."""
        session = self.session
        every = round(_POINT_S / PERIOD_S)
        flown = np.array(session.pilot.samples)[::every]
        table = {
            "pathgene": version(),
            "aircraft": session.mission.aircraft.name,
            "planner": self.planner,
            "board": self.board,
            "processor_ms": 1000 * self.constant_s,
            "scenario": session.scenario.source or None,
            "read": {"zones": [each.to_dict() for each in session.scenario.readings]},
            **self.outcome.to_dict(),
            "changes": [change.to_dict() for change in session.changes],
            "legs": [{"since_s": leg.since_s, "kind": leg.kind} for leg in session.pilot.legs],
            "track": {
                "t_s": np.round(PERIOD_S * every * np.arange(len(flown)), 2).tolist(),
                **{
                    name: np.round(flown[:, column], digits).tolist()
                    for column, (name, digits) in enumerate(_COLUMNS.items(), 1)
                },
            },
        }
        plain: dict[str, Any] = finite(table)
        return plain
