"""A planned path, as the input of every file format."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pathgene.host.formats.flight_plan import FlightPlan
from pathgene.host.formats.shapes import Shape
from pathgene.host.terrain import Terrain


__all__ = ["Curve", "Point", "Points", "Track"]

#: A position in metres of the terrain's local frame: x, y and altitude.
Point = tuple[float, float, float]


class Points(Protocol):
    """Points along a curve, all arrays (k,) float64 metres."""

    @property
    def x(self) -> NDArray[np.float64]:
        """Metres east."""

    @property
    def y(self) -> NDArray[np.float64]:
        """Metres north."""

    @property
    def z(self) -> NDArray[np.float64]:
        """Altitude."""


class Curve(Protocol):
    """The smoothed path, whose turns are arcs."""

    @property
    def length_m(self) -> float:
        """Length in three dimensions."""

    def sample(self, step_m: float) -> Points:
        """Return points that are at most ``step_m`` apart, ends included."""


@dataclass(frozen=True, eq=False)
class Track:
    """A planned path.

    Parameters
    ----------
    waypoints : ndarray
        Waypoints, (n, 3) float64 metres of the terrain's local frame, start and goal included.
    curve : Curve
        The same path, smoothed.
    terrain : Terrain
        The terrain, which knows its place on Earth if it has one.
    points : sequence of (str, (float, float, float))
        The points of the mission with their names, in the order of the flight.
    names : mapping
        Names of the waypoints at those points, by the index of the waypoint.
    zones : sequence of Shape
        No-fly zones.
    flight : FlightPlan, optional
        The path as an autopilot flies it; given for formats whose row has ``flown``.
    page : callable, optional
        Returns the page of the plan; given for the format ``html``.
    """

    waypoints: NDArray[np.float64]
    curve: Curve
    terrain: Terrain
    points: Sequence[tuple[str, Point]]
    names: Mapping[int, str] = field(default_factory=dict)
    zones: Sequence[Shape] = ()
    flight: FlightPlan | None = None
    page: Callable[[], str] | None = None

    @property
    def flown(self) -> FlightPlan:
        """The path as an autopilot flies it.

        Raises
        ------
        ValueError
            If the track has none.
        """
        if self.flight is None:
            raise ValueError("The format needs a flight plan; its row must say flown=True")
        return self.flight
