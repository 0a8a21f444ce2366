"""A checked mission as pictures and pages draw it: its flight in samples, and its faults."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Samples
from pathgene.host.formats.flight_plan import Circling
from pathgene.host.mission.foreign.check import MissionCheck
from pathgene.host.mission.foreign.track import Track
from pathgene.host.report.along import surface_and_demand


__all__ = ["DrawnFlight", "Mark", "drawn_flight"]

Floats = NDArray[np.float64]

# Samples of a flight: the ends of its pieces are samples, too.
_SAMPLES = 3000


@dataclass(frozen=True)
class Mark:
    """The place of a fault.

    Parameters
    ----------
    number : int
        Its number in the list of faults, from 1.
    place : tuple of float
        x, y and altitude of its worst place, metres.
    at_m : float or None
        Metres flown to the place; None for a circle to which no leg leads.
    """

    number: int
    place: tuple[float, float, float]
    at_m: float | None


@dataclass(frozen=True, eq=False)
class DrawnFlight:
    """The flight of a mission in samples.

    Parts of a mission that are flown on their own follow each other, with a sample of NaN between
    them; the distance flown counts on.

    Parameters
    ----------
    samples : Samples
        The samples, (k,).
    ground, highest, demanded : ndarray
        As :func:`pathgene.host.report.along.surface_and_demand` returns them, (k,) metres.
    broken : ndarray
        True where a limit is broken, (k,) bool.
    spans : tuple of (str, float, float)
        The limit of each fault of a leg, and the metres flown where it begins and ends.
    points : ndarray
        The points of the mission, (n, 3) metres; at least one.
    circles : tuple of Circling
        Each circle that is flown.
    marks : tuple of Mark
        The place of each fault, in the order of the list.
    """

    samples: Samples
    ground: Floats
    highest: Floats
    demanded: Floats
    broken: NDArray[np.bool_]
    spans: tuple[tuple[str, float, float], ...]
    points: Floats
    circles: tuple[Circling, ...]
    marks: tuple[Mark, ...]


@dataclass(frozen=True, eq=False)
class _Part:
    """The samples of a chain, (k,): their legs, and horizontal metres along the legs."""

    samples: Samples
    legs: NDArray[np.int64]
    along_m: Floats
    surfaces: tuple[Floats, Floats, Floats]

    def on(self, leg: int, *, is_leg: bool) -> NDArray[np.intp]:
        """Return the samples of a leg, or of the legs at a point."""
        own = self.legs == leg
        return np.flatnonzero(own if is_leg else own | (self.legs == leg - 1))


def drawn_flight(check: MissionCheck) -> DrawnFlight:
    """Return the flight of a mission in samples, with the places of its faults."""
    judge, chains = check.judge, check.flight.chains
    tracks = [judge.track(chain.points) if len(chain.points) > 1 else None for chain in chains]
    length_m = sum(track.length_m for track in tracks if track is not None)
    step_m = max(length_m, 1.0) / _SAMPLES
    parts: list[_Part | None] = []
    flown_m = 0.0
    for number, track in enumerate(tracks):
        part = None if track is None else _part(check, number, track, flown_m, step_m)
        flown_m = flown_m if part is None else float(part.samples.s[-1])
        parts.append(part)
    broken = [np.zeros(0 if part is None else len(part.legs), bool) for part in parts]
    marks, spans = [], []
    for number, fault in enumerate(check.faults, start=1):
        part, at_m = parts[fault.chain], None
        if part is not None:
            own = part.on(fault.leg, is_leg=fault.is_leg)
            samples = part.samples
            x, y, z = fault.place
            away = np.hypot(np.hypot(samples.x[own] - x, samples.y[own] - y), samples.z[own] - z)
            near = int(own[np.argmin(away)])
            at_m = float(samples.s[near])
            broken[fault.chain][near] = True
            if fault.is_leg:
                first, last = np.interp(fault.span_m, part.along_m[own], samples.s[own]).tolist()
                spans.append((fault.limit, first, last))
                inside = (samples.s[own] >= first) & (samples.s[own] <= last)
                broken[fault.chain][own[inside]] = True
        marks.append(Mark(number, fault.place, at_m))
    flown = [(part, each) for part, each in zip(parts, broken, strict=True) if part is not None]
    points = [point for chain in chains for point in chain.points]
    names = ("s", "x", "y", "z", "ground", "clearance")
    ground, highest, demanded = (_joined([part.surfaces[i] for part, _ in flown]) for i in range(3))
    return DrawnFlight(
        Samples(*(_joined([getattr(part.samples, name) for part, _ in flown]) for name in names)),
        ground,
        highest,
        demanded,
        _joined([each.astype(float) for _, each in flown]) == 1.0,
        tuple(spans),
        np.array([point.place for point in points]),
        tuple(
            Circling(*point.place, point.circle_m, point.circle_m)
            for point in points
            if point.circle_m is not None
        ),
        tuple(marks),
    )


def _part(check: MissionCheck, number: int, track: Track, flown_m: float, step_m: float) -> _Part:
    """Return the samples of a chain, at most ``step_m`` apart."""
    problem = check.judge.problem
    distances, places, legs, along = [], [], [], []
    for piece, leg, begin_m in zip(
        track.pieces, track.legs.tolist(), track.begins_m.tolist(), strict=True
    ):
        shares = np.linspace(0.0, 1.0, max(math.ceil(piece.length_m / step_m), 1) + 1)
        distances.append(flown_m + piece.length_m * shares)
        places.append(piece.points(shares))
        legs.append(np.full(len(shares), leg))
        along.append(begin_m + piece.run_m * shares)
        flown_m += piece.length_m
    x, y, z = np.ascontiguousarray(np.concatenate(places).T)
    ground = problem.terrain.ground(x, y)
    samples = Samples(np.concatenate(distances), x, y, z, ground, z - ground)
    demand = check.judge.demand(check.flight.chains[number])
    surfaces = surface_and_demand(problem, samples, demand)
    return _Part(samples, np.concatenate(legs), np.concatenate(along), surfaces)


def _joined(parts: list[Floats]) -> Floats:
    """Return parts one after another, with NaN between them."""
    between = [each for part in parts for each in (part, np.array([np.nan]))]
    return np.concatenate(between[:-1]) if between else np.empty(0)
