"""Scenarios of replans in flight, drawn from a number and the same for every planner."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from bench.chip_runs import terrains
from bench.scenarios import problem
from pathgene.host.errors import InputError
from pathgene.host.evaluation.reference import problem_utopia
from pathgene.host.problem.aircraft import load
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon, Zone
from pathgene.host.replanning.scenario import Event, NewZone, Placed, Scenario


#: Kinds of events, in rotation.
KINDS = (
    "next leg",
    "far ahead",
    "polygon ahead",
    "over the aircraft",
    "two at once",
    "over the goal, then gone",
    "over the goal",
    "drifting storm",
    "another goal",
    "wind turns",
    "comes and goes",
    "board lost",
)

# Distances from start to goal, and heights of both above ground, in metres.
_LENGTHS_M = 3_000.0, 7_000.0
_HEIGHTS_M = 40.0, 150.0
# Maximum number of zones at the beginning of a mission, and radii of zones in metres.
_MOST_ZONES = 2
_RADII_M = 100.0, 400.0
# Shares of the flight time at which events happen.
_SHARES = 0.1, 0.6
_WIND_M_S = 8.0
_STORM_M_S = 6.0
_GONE_S = 60.0
# Distance of ends from the edge of the map and from zones, metres.
_EDGE_M = 400.0
_CLEAR_M = 250.0


@dataclass(frozen=True)
class Drawn:
    """A scenario: its number, its kind, the terrain, and its events."""

    number: int
    kind: str
    terrain: str
    scenario: Scenario


def _source(number: int, part: int) -> np.random.Generator:
    return np.random.default_rng((2026, number, part))


def terrain_of(number: int) -> str:
    """Return the terrain of a scenario: the nine maps in rotation."""
    every = terrains()
    return every[number // len(KINDS) % len(every)]


def draw_mission(number: int) -> Problem:
    """Return the mission of a scenario: ends anywhere on its terrain, and some zones in between."""
    source = _source(number, 0)
    terrain = problem(terrain_of(number)).terrain
    size = np.array((terrain.width_m, terrain.height_m))
    for _ in itertools.repeat(None):
        length = source.uniform(*_LENGTHS_M)
        start = source.uniform(_EDGE_M, size - _EDGE_M)
        angle = source.uniform(0, 2 * math.pi)
        goal = start + length * np.array((math.cos(angle), math.sin(angle)))
        if not ((goal > _EDGE_M) & (goal < size - _EDGE_M)).all():
            continue
        zones: list[Zone] = []
        for _ in range(int(source.integers(_MOST_ZONES + 1))):
            radius = float(source.uniform(*_RADII_M))
            centre = start + source.uniform(0.2, 0.8) * (goal - start) + source.normal(size=2) * 400
            if all(np.hypot(*(centre - end)) > radius + _CLEAR_M for end in (start, goal)):
                x, y = centre.tolist()
                zones.append(Circle(x, y, radius, name=f"zone {len(zones) + 1}"))
        heights = source.uniform(*_HEIGHTS_M, size=2)
        first, last = (
            (*end.tolist(), float(terrain.ground(*end)) + float(height))
            for end, height in zip((start, goal), heights, strict=True)
        )
        try:
            mission = Problem(terrain, first, last, load("silver-fox"), zones, rules=Rules())
            # Costs are relative to the straight line; a steep glide has no cost.
            problem_utopia(mission)
        except InputError:
            continue
        return mission
    raise AssertionError


def draw_scenario(number: int, mission: Problem, seconds: float) -> Drawn:
    """Return the events during a flight of ``seconds``."""
    source = _source(number, 1)
    kind = KINDS[number % len(KINDS)]
    at_s = round(float(source.uniform(*_SHARES)) * seconds, 2)
    radius = float(source.uniform(*_RADII_M))
    speed = mission.aircraft.cruise_speed_m_s
    ahead = radius + float(source.uniform(1.0, 4.0)) * mission.limits.turn_radius_m
    far = ahead + float(source.uniform(0.2, 0.6)) * speed * (seconds - at_s)
    near = NewZone(Placed("path", radius, ahead))
    angle = float(source.uniform(0, 2 * math.pi))
    way = math.cos(angle), math.sin(angle)
    events: tuple[Event, ...]
    if kind == "next leg":
        events = (Event(at_s, (near,)),)
    elif kind == "far ahead":
        events = (Event(at_s, (NewZone(Placed("path", radius, far)),)),)
    elif kind == "polygon ahead":
        events = (Event(at_s, (NewZone(_polygon(source, mission, radius)),)),)
    elif kind == "over the aircraft":
        events = (Event(at_s, (NewZone(Placed("aircraft", radius)),)),)
    elif kind == "two at once":
        events = (Event(at_s, (near, NewZone(Placed("path", 0.7 * radius, far)))),)
    elif kind == "over the goal, then gone":
        storm = NewZone(Placed("goal", radius), "storm")
        events = (Event(at_s, (storm,)), Event(at_s + _GONE_S, gone=("storm",)))
    elif kind == "over the goal":
        events = (Event(at_s, (NewZone(Placed("goal", radius)),)),)
    elif kind == "drifting storm":
        drift = _STORM_M_S * way[0], _STORM_M_S * way[1]
        storm = NewZone(Placed("path", radius, far), "storm", drift)
        events = (Event(at_s, (storm,)), Event(at_s + 2 * _GONE_S, gone=("storm",)))
    elif kind == "another goal":
        events = (Event(at_s, goal=_goal(source, mission)),)
    elif kind == "wind turns":
        events = (Event(at_s, wind=(_WIND_M_S * way[0], _WIND_M_S * way[1])),)
    elif kind == "comes and goes":
        storm = NewZone(Placed("path", radius, far), "storm")
        events = (Event(at_s, (storm,)), Event(at_s + 10.0, gone=("storm",)))
    else:
        events = (Event(at_s, board_lost=True), Event(at_s + 1.0, (near,)))
    return Drawn(number, kind, terrain_of(number), Scenario(events))


def _polygon(source: np.random.Generator, mission: Problem, radius: float) -> Zone:
    """Return a polygon on the straight line to the goal that does not contain the goal."""
    start, goal = np.array(mission.start[:2]), np.array(mission.goal[:2])
    share = float(source.uniform(0.4, 0.7))
    angles = np.sort(source.uniform(0, 2 * math.pi, size=int(source.integers(4, 9))))
    corners = (
        start + share * (goal - start) + radius * np.column_stack((np.cos(angles), np.sin(angles)))
    )
    return Polygon(tuple(map(tuple, corners.tolist())))


def _goal(source: np.random.Generator, mission: Problem) -> tuple[float, float, float]:
    """Return a new goal, a few kilometres from the previous one."""
    terrain = mission.terrain
    size = np.array((terrain.width_m, terrain.height_m))
    while True:
        x, y = np.clip(
            np.array(mission.goal[:2]) + source.normal(size=2) * 1_500, _EDGE_M, size - _EDGE_M
        ).tolist()
        z = float(terrain.ground(x, y)) + float(source.uniform(*_HEIGHTS_M))
        if math.isfinite(z) and not any(
            bool(zone.covers(np.array([x]), np.array([y]))[0, 0]) for zone in mission.zones
        ):
            return x, y, z
