"""A flight during which the situation changes: plans, holds and routes out, in virtual time.

Simulated seconds advance by the time of planning (:mod:`pathgene.host.replanning.planner`). A plan
begins at the point of the current track that the aircraft will reach within the planner's time
budget, with the heading there; once the plan is ready, the flight continues along it. Until then,
and if there is no plan, the aircraft follows its current track. Before that stops being safe, it
turns onto a circle that has been checked, and planning continues from there.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.flight.flight import PERIOD_S, Flight, Sample
from pathgene.host.flight.models import FlightModel, model_for
from pathgene.host.problem.problem import Problem
from pathgene.host.replanning.airspace import DRIFT_S, Airspace
from pathgene.host.replanning.departure import Departure, depart, fault_of
from pathgene.host.replanning.evasion import (
    Holding,
    holding_on,
    shortest_way_out_m,
    way_on,
    way_out,
)
from pathgene.host.replanning.pilot import Change, Pending, Pilot
from pathgene.host.replanning.planner import Attempt, InFlightPlanner, PlanningTime
from pathgene.host.replanning.present import Present
from pathgene.host.replanning.scenario import Event, Scenario, check_mission, named_zones
from pathgene.host.replanning.tracks import Track, end_of, part, pose_at, run_of
from pathgene.host.terrain.surface import surface_below


__all__ = ["Session"]

#: Virtual time in seconds of a decision without a plan: onto a circle, or out of a zone.
REACTION_S = 0.02
# Distance in metres astern of the aircraft at which a new track begins, so that the guidance finds
# its place on it.
_BACK_M = 60.0
# Minimum distance from the aircraft to the beginning of a plan, metres.
_AHEAD_M = 2.0
# Lengths of the straight line after a route out, in turn radii: the first safe one is used.
_ON_RADII = 6.0, 3.0, 1.0
# Attempts in a row, the pause after them and its increase each time, and the longest pause.
_IN_A_ROW, _PAUSE_S, _LONGEST_PAUSE_S = 4, 3.0, 20.0
# Number of rounds of a holding track, and the longest flight without a path, seconds.
_ROUNDS = 60
_MOST_WAITING_S = 300.0
# Period and look-ahead of the search for a holding circle, seconds.
_READY_S, _READY_AHEAD_S = 5.0, 60.0
# Period of the search while a circle is needed, and pause if only a circle helps, seconds.
_URGENT_S, _WAIT_S = 0.5, 0.25
# If the track need not change, a new path is still taken if it is this much shorter.
_GAIN = 0.01
_LOST_M = 3000.0
# Samples between two checks of the ground below; the verdict checks every sample.
_GROUND_LOOKS = 10


class Session:
    """A flight of a planned path during which events happen.

    Parameters
    ----------
    mission : Problem
        The problem of the path, with rules.
    path : array_like
        Its waypoints, (n, 3) metres.
    scenario : Scenario
        Events of the flight. :meth:`happen` adds to them during the flight.
    fallback : InFlightPlanner, optional
        Takes over if the board of ``planner`` is lost; also prepared.
    gusts, seed
        As for :class:`pathgene.host.flight.flight.Flight`.

    Attributes
    ----------
    airspace : Airspace
        Current and past zones, goal and wind.
    ended : str
        Empty during the flight: ``arrived``, ``holding``, ``crashed`` or ``lost``.

    Raises
    ------
    InputError
        If the problem is ``as_paper`` or has via points, the aircraft has no flight model, or
        JSBSim is missing.
    """

    def __init__(
        self,
        mission: Problem,
        path: Any,
        planner: InFlightPlanner,
        scenario: Scenario,
        *,
        fallback: InFlightPlanner | None = None,
        model: FlightModel | None = None,
        gusts: str = "none",
        seed: int = 0,
        say: Callable[[str], object] = lambda _: None,
    ) -> None:
        check_mission(mission, scenario)
        self.mission, self.scenario = mission, scenario
        self._planner, self._fallback, self._say = planner, fallback, say
        self.airspace = Airspace(mission)
        track: Track = Evaluator(mission, threads=1).track(path).pieces
        flight = Flight(
            track,
            mission.terrain,
            mission.aircraft,
            model or model_for(mission.aircraft),
            wind=mission.frame_wind,
            gusts=gusts,
            seed=seed,
        )
        self.pilot = Pilot(flight, track, mission.aircraft)
        self.changes: list[Change] = []
        self.ended = ""
        self._events = list(scenario.events)
        self._present = self._look(0.0)
        self._change: Change | None = None
        self._pending: Pending | None = None
        self._holding: Holding | None = None
        self._unsafe_m = math.inf
        self._out_m = 0.0
        self._retry_s = self._next_look_s = 0.0
        self._next_drift_s = math.inf
        self._number = 0
        self._waits_since_s: float | None = None
        self._looks = self._found = 0

    # --- Shown to callers -----------------------------------------------------------------------

    @property
    def ready_share(self) -> float:
        """Share of the routine searches that found a safe circle."""
        return self._found / self._looks if self._looks else 1.0

    def happen(self, event: Event) -> None:
        """Apply an event now."""
        now = self.pilot.time_s
        due = sum(each.at_s <= now for each in self._events)
        self._events.insert(due, dataclasses.replace(event, at_s=now))

    def run(self) -> None:
        """Fly to the end."""
        while not self.ended:
            self.step()

    def step(self) -> None:
        """Fly for ``PERIOD_S``, with the events and decisions of this period."""
        now = self.pilot.time_s
        while self._events and self._events[0].at_s <= now:
            self._happen(self._events.pop(0), now)
        if now >= self._next_drift_s:
            self._next_drift_s = now + DRIFT_S
            if names := self.airspace.drift(now):
                self._drifted(now, names)
        if self._pending is not None and now >= self._pending.ready_s:
            self._settle(self._pending, now)
        if self._change is not None and self._pending is None and now >= self._retry_s:
            self._plan(self._change, now)
        self._keep_safe(now)
        if self.pilot.kind == "way-out" or (self.pilot.kind == "path" and self._is_sought):
            self._fly_on(self._reach_m)
        self._end(self.pilot.step())

    # --- Events ---------------------------------------------------------------------------------

    def _happen(self, event: Event, now: float) -> None:
        if event.board_lost:
            self._planner.lose_board()
        changed = event.appear or event.gone or event.goal is not None or event.wind is not None
        if changed:
            event = dataclasses.replace(event, at_s=now)
            self.airspace.happen(event, self._place)
        if any(new.velocity != (0.0, 0.0) for new in event.appear):
            self._next_drift_s = now + DRIFT_S
        if event.wind is not None:
            self.pilot.flight.turn_wind(self.mission.in_frame(event.wind))
        if changed:
            self._update(now)
            self._changed(now, event.what, must=event.goal is not None or event.wind is not None)
        else:
            self._say(f"{now:.1f} s: {event.what}.")

    def _drifted(self, now: float, names: Sequence[str]) -> None:
        """Note where zones have drifted to; this is a change only if it affects the track."""
        self._update(now)
        if self._is_sought:
            # A plan is already being searched for, now with the zones at their current places.
            self._pending, self._retry_s = None, min(self._retry_s, now)
        elif math.isfinite(self._unsafe_m):
            verb = "has" if len(names) == 1 else "have"
            self._changed(now, f"{named_zones(names)} {verb} drifted", must=False)

    def _update(self, now: float) -> None:
        """Update the current situation, and how far the track is safe in it."""
        self._present = self._look(now)
        self._unsafe_m = self._present.safe_until_m(self.pilot.track, self.pilot.along_m)
        self._holding, self._next_look_s = None, now

    def _changed(self, now: float, what: str, *, must: bool) -> None:
        """Note a change, and plan again if the track is unsafe or a better one may exist."""
        inside_m = shortest_way_out_m(self._present, self.pilot.pose())
        needed = must or math.isfinite(self._unsafe_m) or self.pilot.kind != "path"
        change = Change(now, what, needed, inside_m)
        earlier = self._change
        if earlier is not None and earlier.needed and earlier.active_s is None:
            # The plan for the earlier change is not ready; this one replaces it.
            change.needed = True
        self.changes.append(change)
        self._change, self._pending = change, None
        self._number, self._retry_s = 0, now
        self._say(f"{now:.1f} s: {what}{'' if needed else '; the path is not concerned'}.")

    def _place(self, on: str, ahead_m: float) -> tuple[float, float]:
        if on == "goal":
            return self.airspace.goal[:2]
        if on == "aircraft":
            return self.pilot.flight.state.x, self.pilot.flight.state.y
        pose = self.pilot.pose(ahead_m)
        return pose.x, pose.y

    def _look(self, now: float) -> Present:
        air = self.airspace
        return Present(self.mission, air.zones_at(now), air.goal, air.wind)

    def _refresh(self, now: float) -> None:
        """Count the times of zones from now."""
        if any(zone.t0_s is not None or zone.t1_s is not None for zone in self._present.zones):
            self._present = self._look(now)

    # --- Planning -------------------------------------------------------------------------------

    def _plan(self, change: Change, now: float) -> None:
        """Begin an attempt."""
        self._refresh(now)
        planner = self._active_planner(now)
        leaves_m = self._leaves_m(planner.budget_s)
        if self.pilot.kind != "way-out" and self._present.zones_at(self.pilot.pose(self._reach_m)):
            self._leave_zone(now)
        if self.pilot.kind == "way-out":
            self._fly_on(self._leaves_m(planner.budget_s) - self.pilot.along_m)
            leaves_m = max(self._leaves_m(planner.budget_s), self._out_m)
        elif leaves_m > self._unsafe_m:
            # No path from there is safe; a path from the circle may be.
            self._retry_s = now + _WAIT_S
            return
        departure = depart(
            self._present, self.pilot.track, leaves_m, is_committed=planner.is_on_chip
        )
        attempt = self._attempted(planner, departure)
        track: Track | None = None
        if attempt.plan is not None:
            path = attempt.plan.evaluator.track(attempt.plan.path).pieces
            since_m = leaves_m if self.pilot.kind == "way-out" else self.pilot.along_m
            ahead = departure.joined(path, since_m)
            fault = fault_of(ahead, self._present)
            if fault:
                attempt = attempt.refused(fault)
            elif not change.needed and not self._is_better(ahead):
                attempt = attempt.refused("The new path is no better.", hopeless=True)
            else:
                track = departure.whole(path, self.pilot.along_m)
        change.attempts.append((now, attempt))
        self._number += 1
        self._pending = Pending(now + attempt.time.total_s, attempt, leaves_m, track)

    def _attempted(self, planner: InFlightPlanner, departure: Departure) -> Attempt:
        try:
            lead_m = 0.0 if departure.lead is None else departure.lead.run_m
            ahead_m = departure.leaves_m - self.pilot.along_m + lead_m
            after_s = max(ahead_m, 0.0) / self.pilot.ground_speed_m_s
            problem = departure.problem(self._present, self.pilot.aircraft, after_s)
        except InputError as error:
            # Takes no time, because the host refuses it itself. A different start may help, a
            # different goal will not.
            is_hopeless = self._present.is_goal_in_zone
            return Attempt(None, PlanningTime(), planner.name, str(error), hopeless=is_hopeless)
        return planner.attempt(problem, self._number)

    def _active_planner(self, now: float) -> InFlightPlanner:
        planner = self._planner
        if planner.lost and self._fallback is not None and self._number > 0:
            self._say(f"{now:.1f} s: {planner.lost} {self._fallback.name} plans in its place.")
            self._planner, self._fallback = self._fallback, None
        return self._planner

    def _settle(self, pending: Pending, now: float) -> None:
        """Handle the result of an attempt."""
        self._pending = None
        change = self._change
        assert change is not None
        attempt = pending.attempt
        if pending.track is None or self.pilot.along_m > pending.leaves_m:
            reason = attempt.reason or "The path came too late."
            self._say(f"{now:.2f} s: no new path: {reason}")
            if attempt.hopeless:
                self._retry_s = math.inf
                if not change.needed:
                    self._change = None
            elif self._number % _IN_A_ROW == 0:
                rows = self._number // _IN_A_ROW
                self._retry_s = now + min(_PAUSE_S * rows, _LONGEST_PAUSE_S)
            return
        assert attempt.plan is not None
        # The guidance takes it at its next update; that wait is not the planner's time.
        change.active_s = pending.ready_s - change.at_s
        change.fitness = attempt.plan.evaluation.fitness
        change.flown_m = self.pilot.ground_speed_m_s * change.active_s
        self._change = None
        self._fly("path", pending.track)
        self._say(
            f"{now:.2f} s: a new path by {attempt.planner} after {1000 * change.active_s:.1f} ms "
            f"and {change.flown_m:.2f} m."
        )

    def _is_better(self, track: Track) -> bool:
        """Return whether a track is worth leaving a safe one for."""
        left = run_of(part(self.pilot.track, self.pilot.along_m))
        return run_of(track) < (1 - _GAIN) * left

    # --- Where it begins ------------------------------------------------------------------------

    def _leaves_m(self, budget_s: float) -> float:
        """Return the distance along the track at which a plan begins."""
        fastest = self._present.speeds_m_s[1]
        leaves_m = self.pilot.along_m + fastest * (budget_s + PERIOD_S) + _AHEAD_M
        if self.scenario.autopilot == "finishes-leg":
            ends = 0.0
            for piece in self.pilot.track:
                ends += piece.run_m
                if ends >= leaves_m:
                    return ends
        return leaves_m

    @property
    def _reach_m(self) -> float:
        """Metres flown until a decision that needs no plan."""
        return self._present.speeds_m_s[1] * (REACTION_S + PERIOD_S)

    # --- Without a plan -------------------------------------------------------------------------

    def _leave_zone(self, now: float) -> None:
        """Fly the shortest route out of the zone that the aircraft is in, if there is one."""
        leaves_m = self.pilot.along_m + self._reach_m
        way = way_out(self._present, pose_at(self.pilot.track, leaves_m))
        if way is None:
            return
        here = self._present.zones_at(pose_at(self.pilot.track, leaves_m))
        names = named_zones([self._present.zones[number].name for number in here] or [""])
        self._say(f"{now:.1f} s: in {names}; the shortest way out is {run_of(way):.0f} m.")
        before = part(self.pilot.track, self.pilot.along_m - _BACK_M, leaves_m)
        self._out_m = run_of((*before, *way))
        end = end_of(way[-1])
        on = [(end.straight(radii * self._present.turn_radius_m),) for radii in _ON_RADII]
        behind = next((each for each in on if self._present.is_safe(each)), ())
        self._fly("way-out", (*before, *way, *behind))
        self._waits_since_s = now

    def _fly_on(self, ahead_m: float) -> None:
        """Extend a track that ends within ``ahead_m`` if there is neither a path nor a circle."""
        track = self.pilot.track
        if self.pilot.along_m + ahead_m < run_of(track):
            return
        before = part(track, self.pilot.along_m - _BACK_M)
        way = way_on(self._present, end_of(before[-1]))
        since_s = self._waits_since_s
        self._fly("way-out", (*before, *way))
        self._out_m = run_of(before)
        self._waits_since_s = self.pilot.time_s if since_s is None else since_s

    def _keep_safe(self, now: float) -> None:
        """Turn onto a circle before the track stops being safe; search for one while it is safe."""
        if self.pilot.kind == "holding" and math.isinf(self._unsafe_m):
            return
        if self.pilot.kind == "way-out":
            first_m, last_m, every_s = self._out_m, run_of(self.pilot.track), _URGENT_S
        elif self._is_sought:
            first_m, last_m, every_s = 0.0, self._unsafe_m, _URGENT_S
        else:
            far_m = _READY_AHEAD_S * self._present.speeds_m_s[1]
            first_m, last_m, every_s = 0.0, self.pilot.along_m + far_m, _READY_S
        first_m = max(first_m, self.pilot.along_m + self._reach_m)
        if self._holding is not None and self._holding.along_m < self.pilot.along_m + self._reach_m:
            if every_s == _URGENT_S:
                self._enter(self._holding, now)
                return
            self._holding = None
        if self._holding is None and now >= self._next_look_s:
            self._next_look_s = now + every_s
            self._refresh(now)
            if first_m >= min(last_m, run_of(self.pilot.track)):
                return
            self._holding = holding_on(self._present, self.pilot.track, first_m, last_m)
            if every_s == _READY_S:
                self._looks += 1
                self._found += self._holding is not None

    def _enter(self, holding: Holding, now: float) -> None:
        self._say(f"{now:.1f} s: no new path yet; onto a circle that is safe.")
        before = part(self.pilot.track, self.pilot.along_m - _BACK_M, holding.along_m)
        self._fly("holding", holding.track(before, _ROUNDS))
        self._waits_since_s = now
        if self._change is not None:
            self._change.held = True

    # --- Flying ---------------------------------------------------------------------------------

    def _fly(self, kind: str, track: Track) -> None:
        self.pilot.follow(kind, track)
        # A pending plan starts from the old track and is therefore dropped.
        self._pending, self._unsafe_m = None, math.inf
        self._holding = self._waits_since_s = None
        self._next_look_s = self.pilot.time_s

    def _is_below_ground(self, x: float, y: float, z: float) -> bool:
        surface = surface_below(self.mission.terrain, np.array([x]), np.array([y]), void_m=math.nan)
        return z < float(surface[0])

    def _end(self, sample: Sample) -> None:
        _, x, y, z = sample[:4]
        if not all(map(math.isfinite, sample)) or abs(sample[5]) > _LOST_M:
            self.ended = "lost"
        elif len(self.pilot.samples) % _GROUND_LOOKS == 0 and self._is_below_ground(x, y, z):
            self.ended = "crashed"
        elif self.pilot.kind == "path" and self.pilot.has_arrived and not self._is_sought:
            self.ended = "arrived"
        elif not self._events and self._waited_s > _MOST_WAITING_S:
            self.ended = "holding" if self.pilot.kind == "holding" else "lost"

    @property
    def _is_sought(self) -> bool:
        """True while a new path is needed."""
        return self._change is not None and self._change.needed

    @property
    def _waited_s(self) -> float:
        """Seconds flown without a path."""
        return 0.0 if self._waits_since_s is None else self.pilot.time_s - self._waits_since_s
