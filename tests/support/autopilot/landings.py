"""Landings of exported missions, flown by the simulated autopilots and judged by a rule of ours."""

import math
from dataclasses import dataclass

import numpy as np

from pathgene.host.evaluation import Evaluator
from pathgene.host.flight.ground import demanded_m, known_surface_m
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.mission.autopilot.hand_over import HandOver
from pathgene.host.mission.ending import Ending
from pathgene.sim.autopilot.autopilot import Autopilot, Start
from pathgene.sim.autopilot.connection import Connection
from pathgene.sim.autopilot.items import MISSION
from pathgene.sim.autopilot.pilot import Kind, Mode
from pathgene.sim.autopilot.wind import Wind
from pathgene.sim.autopilot_flight import (
    airframe_of,
    give_mission,
    parameters_of,
    px4_parameters_of,
)


LAND, START, ACCEPTED = 21, 300, 0
# The clearance near the touch-down, as docs/files.md states it.
SHARE_OF_HEIGHT = 0.5
# Less clearance is not judged: ArduPlane flares from twice this height on, at most.
_TOUCHDOWN_M = 3.0


@dataclass
class Landed:
    """A flight, in the frame of the terrain.

    Attributes
    ----------
    along_m, across_m, height_m : ndarray
        Place along and beside the centreline, and height above the touch-down.
    share : ndarray
        Share of the clearance that is required after the goal.
    number : ndarray
        Number of the item under way.
    """

    autopilot: Autopilot
    along_m: np.ndarray
    across_m: np.ndarray
    height_m: np.ndarray
    share: np.ndarray
    number: np.ndarray

    @property
    def touch_down_m(self):
        """Place of the touch-down, along and beside the centreline."""
        return self.along_m[-1], self.across_m[-1]

    @property
    def over_m(self):
        """Height at which the aircraft passes the place; 0 if it touches down before."""
        after = self.along_m[-300:] >= 0
        return self.height_m[-300:][after][0] if after.any() else 0.0


def plan_of(problem, land):
    """Return the flight plan of the straight path with a landing at its end."""
    path = np.array([problem.start, problem.goal])
    track = Evaluator(problem, threads=1).track(path)
    return flight_plan(problem, track, feasible=True, wanted=HandOver(ending=Ending("land", land)))


def parameters_for(kind, aircraft):
    if kind is Kind.ARDUPLANE:
        return parameters_of(aircraft)
    return px4_parameters_of(aircraft)


def airborne(problem, plan, kind, **values):
    """Return an autopilot in the air over the start, with the mission."""
    terrain = problem.terrain
    east, north = problem.goal[0] - problem.start[0], problem.goal[1] - problem.start[1]
    heading = problem.true_heading_deg(math.degrees(math.atan2(east, north)))

    def ground(lat, lon):
        x, y = terrain.to_local(np.array([lat]), np.array([lon]))
        return float(known_surface_m(terrain, x, y)[0])

    autopilot = Autopilot(
        kind,
        Start(plan.home, (0.0, 0.0), problem.start[2] - plan.home[2], heading),
        parameters=parameters_for(kind, problem.aircraft),
        airframe=airframe_of(problem.aircraft),
        wind=Wind(*problem.wind, gusts_m_s=1.0 if any(problem.wind) else 0.0, seed=1),
        ground=ground,
    )
    autopilot.parameters.update(values)
    give_mission(autopilot, plan)
    return autopilot


def start(autopilot):
    """Start the mission by a command over MAVLink; return the result."""
    connection = Connection(autopilot)
    connection.mav.command_long_send(1, 1, START, 0, *([0.0] * 7))
    return connection.recv_match(type="COMMAND_ACK", timeout=5.0).result


def fly(problem, plan, kind, *, go_around_m=None, most_s=3000.0, parameters=None):
    """Fly a mission to its landing, or with a missed approach from a height on."""
    autopilot = airborne(problem, plan, kind, **(parameters or {}))
    assert start(autopilot) == ACCEPTED
    pilot = autopilot.pilot
    x0, y0, z0 = plan.end.way[-1]
    rows, missed = [], False
    while pilot.time_s < most_s and pilot.mode is not Mode.LANDED:
        number = pilot.sequencer.index
        pilot.tick()
        low = go_around_m is not None and pilot.vehicle.altitude_m - z0 < go_around_m
        if low and not missed and pilot.sequencer.command == LAND:
            missed = pilot.go_around()
            most_s = pilot.time_s + 240.0
        rows.append((*pilot.vehicle.place, pilot.vehicle.altitude_m, number, missed))
    table = np.array(rows)
    return _judged(problem, plan, autopilot, table, (x0, y0, z0))


def _judged(problem, plan, autopilot, table, touch_down):
    terrain, plane = problem.terrain, autopilot.earth.plane
    lat, lon = np.array([plane.degrees(place) for place in table[:, :2].tolist()]).T
    x, y = terrain.to_local(lat, lon)
    before, after = np.array(plan.end.way[-2]), np.array(touch_down)
    east, north = (after - before)[:2] / math.hypot(*(after - before)[:2])
    along = (x - after[0]) * east + (y - after[1]) * north
    across = (y - after[1]) * east - (x - after[0]) * north
    height = table[:, 2] - touch_down[2]
    number = table[:, 3].astype(int)
    items = autopilot.lists.items[MISSION]
    lands = np.array([item.command == LAND for item in items])[np.minimum(number, len(items) - 1)]
    required = np.maximum(demanded_m(problem, x, y), 0.0)
    missed = lands & (table[:, 4] > 0)
    # On the glide by the height that is planned there, after a missed approach by the flown one.
    slope = (before[2] - after[2]) / math.hypot(*(after - before)[:2])
    line = np.where(missed, height, -along * slope)
    near = np.minimum(required, SHARE_OF_HEIGHT * np.maximum(line, 0.0))
    required = np.where(lands, near, required)
    clearance = table[:, 2] - known_surface_m(terrain, x, y)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(required > _TOUCHDOWN_M, clearance / required, 9.0)
    share[number <= _goal_number(problem, items)] = 9.0  # The path itself is judged elsewhere.
    return Landed(autopilot, along, across, height, share, number)


def _goal_number(problem, items):
    """Return the number of the waypoint at the goal."""
    (lat,), (lon,) = problem.terrain.to_geographic(*(np.array([v]) for v in problem.goal[:2]))
    away = [
        math.hypot(item.lat - lat, item.lon - lon) if item.command == 16 else math.inf
        for item in items
    ]
    return int(np.argmin(away))
