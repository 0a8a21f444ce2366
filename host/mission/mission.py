"""A mission: a start, points to pass in order, a goal, and optionally a return."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from pathgene.host.errors import InputError, NoPathError
from pathgene.host.evaluation import line_utopia, utopia
from pathgene.host.problem.changes import zones_after
from pathgene.host.problem.ends import Point, check_above_ground, end_point
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.way import WayProblem
from pathgene.host.terrain.surface import surface_below


__all__ = ["MissionProblem"]


@dataclass(frozen=True, eq=False, init=False)
class MissionProblem:
    """Start, via points, goal, and the return to the start: legs from each point to the next.

    A leg starts with the heading at which the previous leg arrives, so the path of all legs turns
    at a via point on a single arc, as at any waypoint, and passes the point on the inside of the
    turn. The headings of ``problem`` apply at the mission's start and at its end.

    Parameters
    ----------
    problem : Problem
        Terrain, start, goal, aircraft, zones, wind and rules.
    via : iterable of (float, float, float)
        Points between start and goal, in order: x, y and altitude. With rules, each is at least the
        clearance above the ground.
    return_to_start : bool
        Fly back from the goal to the start, which is then the end of the mission; the goal becomes
        a via point.
    agl, geo : bool
        As for :class:`Problem`, of the via points.

    Raises
    ------
    InputError
        If a via point is off the map, over a void, in the ground, in a no-fly zone, too low, or
        equal to its neighbour, or if the straight line of a leg cannot be a reference for costs.
    NoPathError
        If such a leg has no path either, for example down into a deep pit.
    """

    problem: Problem
    via: tuple[Point, ...]
    return_to_start: bool

    def __init__(
        self,
        problem: Problem,
        via: Iterable[Sequence[float]] = (),
        return_to_start: bool = False,
        *,
        agl: bool = False,
        geo: bool = False,
    ) -> None:
        points = tuple(
            end_point(f"via point {number}", point, problem.terrain, agl=agl, geo=geo)
            for number, point in enumerate(via, start=1)
        )
        for name, value in (
            ("problem", problem),
            ("via", points),
            ("return_to_start", bool(return_to_start)),
        ):
            object.__setattr__(self, name, value)
        for name, point in zip(self.names[1:], self.way[1:], strict=True):
            if name.startswith("via") or (name == "the goal" and self.return_to_start):
                self._check(name, point)
        for number, (start, stop) in enumerate(itertools.pairwise(self.way)):
            if start == stop:
                first, second = self.names[number : number + 2]
                raise InputError(f"{_upper(first)} and {second} are one point; leave one out.")
        self._check_lines()

    @property
    def way(self) -> tuple[Point, ...]:
        """All points in order: start, via points, goal, and the start again after a return."""
        back = (self.problem.start,) if self.return_to_start else ()
        return (self.problem.start, *self.via, self.problem.goal, *back)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the points of :attr:`way` in sentences."""
        between = (f"via point {number}" for number in range(1, len(self.via) + 1))
        back = ("the start",) if self.return_to_start else ()
        return ("the start", *between, "the goal", *back)

    @property
    def legs(self) -> int:
        """Number of legs, 1 or more."""
        return len(self.way) - 1

    @property
    def straight_m(self) -> float:
        """Length of the straight lines through all points, metres."""
        return sum(itertools.starmap(math.dist, itertools.pairwise(self.way)))

    @cached_property
    def whole(self) -> Problem:
        """The problem of the path of all legs."""
        problem = self.problem
        if self.legs == 1:
            return problem
        return self.part(
            self.way,
            start_heading_deg=problem.start_heading_deg,
            goal_heading_deg=problem.goal_heading_deg,
        )

    def part(
        self,
        way: tuple[Point, ...],
        *,
        start_heading_deg: float | None = None,
        goal_heading_deg: float | None = None,
        elapsed_s: float = 0.0,
    ) -> Problem:
        """Return the problem of a path over some points of the mission.

        Parameters
        ----------
        start_heading_deg, goal_heading_deg : float, optional
            Headings at the first and last points; ignored under the papers' rules (``as_paper``).
        elapsed_s : float
            Seconds flown before the first point.
        """
        problem = self.problem
        headings: dict[str, Any] = {}
        if not problem.as_paper:
            headings = {
                "start_heading_deg": start_heading_deg,
                "goal_heading_deg": goal_heading_deg,
            }
        return WayProblem(
            problem.terrain,
            way,
            aircraft=problem.aircraft,
            zones=zones_after(problem.zones, elapsed_s),
            wind=problem.wind,
            ds_m=problem.ds_m,
            rules=problem.rules,
            as_paper=problem.as_paper,
            zones_reading=problem.zones_reading,
            **headings,
        )

    def name_of(self, leg: int) -> str:
        """Return the name of a leg, counted from 0: its number from 1 and its ends."""
        first, second = self.names[leg : leg + 2]
        return f"leg {leg + 1}, from {first} to {second}"

    def leg(
        self,
        leg: int,
        *,
        start_heading_deg: float | None = None,
        goal_heading_deg: float | None = None,
        elapsed_s: float = 0.0,
    ) -> Problem:
        """Return the problem of a leg.

        Parameters
        ----------
        leg : int
            Its number, from 0.
        start_heading_deg, goal_heading_deg : float, optional
            Headings at via points; at the ends of the mission, the problem's headings apply.
        elapsed_s : float
            Seconds flown before the leg: the times of its zones count from its own start.

        Raises
        ------
        InputError
            If the leg is not a valid problem, for example if it is shorter than the sampling step.
        """
        problem = self.problem
        if self.legs == 1:
            return problem
        start, stop = self.way[leg : leg + 2]
        half_a_cell_m = 0.5 * min(problem.terrain.dx_m, problem.terrain.dy_m)
        headings: dict[str, Any] = {}
        if not problem.as_paper:
            headings = {
                "start_heading_deg": start_heading_deg if leg else problem.start_heading_deg,
                "goal_heading_deg": (
                    problem.goal_heading_deg if leg == self.legs - 1 else goal_heading_deg
                ),
            }
        return Problem(
            problem.terrain,
            start,
            stop,
            problem.aircraft,
            zones_after(problem.zones, elapsed_s),
            problem.wind,
            min(problem.ds_m, max(math.dist(start, stop), half_a_cell_m)),
            rules=problem.rules,
            as_paper=problem.as_paper,
            **headings,
        )

    def _check(self, name: str, point: Point) -> None:
        """Refuse a via point that no path can pass with the whole clearance."""
        problem = self.problem
        check_above_ground(name.removeprefix("the "), problem.terrain, point)
        x, y, z = point
        if zone := problem.zone_at(point):
            raise InputError(
                f"{_upper(name)} at ({x:.10g}, {y:.10g}) is inside {zone}; move it or the zone."
            )
        if problem.rules is None:
            return
        at = np.array([x]), np.array([y])
        surface = float(surface_below(problem.terrain, *at, void_m=math.nan)[0])
        # Next to a void, only the nearest node is known.
        height_m = z - (problem.terrain.ground(x, y) if math.isnan(surface) else surface)
        if height_m < problem.rules.clearance_m:
            raise InputError(
                f"{_upper(name)} is {height_m:.1f} m above the ground, less than the clearance of "
                f"{problem.rules.clearance_m:g} m; raise it or reduce the clearance."
            )
        self._check_edges(name, point)

    def _check_edges(self, name: str, point: Point) -> None:
        """Refuse a via point whose corridor leaves the map, because no path turns there."""
        terrain, rules, (x, y, _) = self.problem.terrain, self.problem.rules, point
        assert rules is not None
        away_m = min(x, terrain.width_m - x, y, terrain.height_m - y)
        if away_m < rules.corridor_m:
            raise InputError(
                f"{_upper(name)} is {away_m:.1f} m from the edge of the map, less than the "
                f"corridor of {rules.corridor_m:g} m; move it "
                f"{math.ceil(rules.corridor_m - away_m)} m into the map or give --corridor "
                f"{math.floor(away_m)}."
            )

    def _check_lines(self) -> None:
        """Refuse a leg whose straight line cannot be a reference for costs.

        A leg whose line is too steep a glide may have no path; then the error gives the reason.
        """
        problem = self.problem
        for index, (start, stop) in enumerate(itertools.pairwise(self.way)):
            single = self.legs == 1
            name = "" if single else f"{_upper(self.name_of(index))}: "
            try:
                utopia(start, stop, problem.aircraft, problem.frame_wind, problem.cost_base_m)
            except InputError as error:
                if not problem.as_paper:
                    # Loads SciPy.
                    from pathgene.host.diagnosis import diagnose

                    reason = diagnose(self.leg(index))
                    if reason.proven or reason.code not in ("not-found", "start", "goal"):
                        raise NoPathError(
                            f"{name}{reason.sentence}", reason, None if single else index + 1
                        ) from error
            try:
                line_utopia(problem, start, stop)
            except InputError as error:
                raise InputError(f"{name}{error}") from None


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]
