"""Where a plan begins on the current track, and how its path joins the track.

Paths of the planner core begin with a straight line, so its plan starts on the track. Paths of
other planners turn at their start, and the evaluation puts that turn before the start: a straight
line leads there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from pathgene.host.evaluation.geometry import Straight
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.changes import zones_after
from pathgene.host.problem.problem import Problem
from pathgene.host.replanning.present import Present
from pathgene.host.replanning.tracks import Pose, Track, is_smooth, part, pose_at


__all__ = ["Departure", "depart", "fault_of"]

# Straight lines that lead to a start: length in turn radii, and share of the steepest climb; the
# first safe one is used. Half of a climbing straight may be the tangent of a turn, where its climb
# is lost.
_LEADS = (1.1, 0.0), (2.0, 0.25), (2.0, 0.45)
# Distance in metres from a new track's beginning to the aircraft, so that the guidance finds its
# place on the track.
_BACK_M = 60.0


@dataclass(frozen=True)
class Departure:
    """The place where a path leaves a track.

    Parameters
    ----------
    lead : Straight or None
        Straight from there to the start of the plan.
    """

    track: Track
    leaves_m: float
    lead: Straight | None

    @property
    def start(self) -> Pose:
        """Start of the plan, with the heading there."""
        pose = pose_at(self.track, self.leaves_m)
        return pose if self.lead is None else pose_at((self.lead,), self.lead.run_m)

    def problem(self, present: Present, aircraft: Aircraft, after_s: float = 0.0) -> Problem:
        """Return the problem of the rest of the flight; a new goal has no heading.

        Parameters
        ----------
        after_s : float
            Seconds from now to its start, from which the times of its zones count.

        Raises
        ------
        InputError
            If its start or goal is in a zone, in the ground or off the map.
        """
        start, mission = self.start, present.mission
        is_goal = present.goal == mission.goal
        return Problem(
            mission.terrain,
            start.point,
            present.goal,
            aircraft,
            zones_after(present.zones, after_s),
            present.wind,
            mission.ds_m,
            rules=mission.rules,
            start_heading_deg=mission.true_heading_deg(start.heading_deg) % 360,
            goal_heading_deg=mission.goal_heading_deg if is_goal else None,
        )

    def joined(self, path: Track, since_m: float) -> Track:
        """Return the track starting at ``since_m``, followed by the path."""
        return (*part(self.track, since_m, self.leaves_m), *self._led(path), *path)

    def whole(self, path: Track, along_m: float) -> Track:
        """Return the new track for an aircraft at ``along_m``; it begins slightly before that."""
        return self.joined(path, along_m - _BACK_M)

    def _led(self, path: Track) -> Track:
        """Return the lead up to where the path's first turn begins, and to its altitude."""
        if self.lead is None:
            return ()
        first = pose_at((self.lead,), 0.0)
        x, y, z = path[0].start
        run_m = math.hypot(x - first.x, y - first.y)
        return (first.straight(run_m, (z - first.z) / run_m),) if run_m > 0 else ()


def depart(present: Present, track: Track, leaves_m: float, *, is_committed: bool) -> Departure:
    """Return the departure of a plan.

    Parameters
    ----------
    leaves_m : float
        Distance along the track at which the plan leaves it.
    is_committed : bool
        Paths of the planner begin with a straight line of at least one turn radius.
    """
    if is_committed:
        return Departure(track, leaves_m, None)
    pose = pose_at(track, leaves_m)
    leads = [
        pose.straight(radii * present.turn_radius_m, share * present.climb(pose))
        for radii, share in _LEADS
    ]
    safe = next((lead for lead in leads if present.is_safe((lead,))), leads[0])
    return Departure(track, leaves_m, safe)


def fault_of(ahead: Track, present: Present) -> str:
    """Return why a new path cannot be flown from the track that it joins; empty if it can."""
    if not is_smooth(ahead):
        # The evaluation has put its first turn before the start.
        return "The path turns too sharply where it begins."
    if not present.is_safe(ahead):
        return "The way to the new path is not safe."
    return ""
