"""A flight of a saved plan in a process of the desk, at a speed to watch or faster.

A page sends a zone of :mod:`pathgene.host.problem.zones` that appears, a :class:`Goal`,
:data:`AHEAD`, :data:`CLEAR`, a :class:`Speed`, or :data:`pathgene.host.web.desk.messages.STOP`,
which leaves no files.
"""

from __future__ import annotations

import contextlib
import dataclasses
import math
import queue
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pathgene.host.errors import InputError
from pathgene.host.web.desk.messages import STOP, Failed, Saved, Sender


if TYPE_CHECKING:
    from pathgene.host.problem.ends import Point
    from pathgene.host.replanning.pilot import Leg
    from pathgene.host.replanning.scenario import Event
    from pathgene.host.replanning.session import Session

__all__ = [
    "AHEAD",
    "CLEAR",
    "ENDED",
    "FASTEST",
    "USUAL",
    "Flown",
    "FlyTask",
    "Goal",
    "Landed",
    "Speed",
    "fly",
]

#: A circle appears on the path ahead; all zones that have appeared are removed.
AHEAD, CLEAR = "ahead", "clear"
#: Speed of a flight that no page shows, as a multiple of the aircraft's speed.
FASTEST = 64.0
#: Why a stopped flight has no files.
ENDED = "The flight was ended, and is not saved."
#: Initial speed.
USUAL = 4.0

# The circle ahead: its radius in turn radii and as a share of the map, whichever is greater, and
# the distance of its edge from the aircraft, in turn radii.
_RADIUS, _SHARE, _AWAY = 2.0, 0.012, 6.0
# Time between two messages, and the longest time that one message covers.
_PERIOD_S, _LONGEST_S = 1 / 30, 0.2
# Number of samples of a flight per drawn sample, and step along a drawn track in metres.
_EVERY, _STEP_M = 10, 10.0
# Drawn length of a circle or a route out, metres.
_SHOWN_M = 1500.0


@dataclass(frozen=True)
class FlyTask:
    """A saved plan to fly.

    Parameters
    ----------
    planner, board : str
        The planner to use in flight, and its board.
    """

    folder: Path
    planner: str
    board: str
    seed: int


@dataclass(frozen=True)
class Speed:
    """Fly ``factor`` times as fast as the aircraft does; 0 pauses the flight."""

    factor: float


@dataclass(frozen=True)
class Goal:
    """A new goal, at the same height above the ground as the first one."""

    x_m: float
    y_m: float


@dataclass(frozen=True, kw_only=True)
class Flown:
    """Updates on a flight since the last message.

    Parameters
    ----------
    time_s : float
        Seconds since the start of the path was passed.
    aircraft : dict
        ``x``, ``y``, ``z`` in metres and ``heading_deg``.
    speed_m_s, clearance_m : float
        Speed over ground; height over the surface, NaN over a void.
    kind : str
        Kind of the track that the aircraft follows: ``path``, ``holding`` or ``way-out``.
    versions : list
        Tracks that the aircraft has begun to follow: a kind, and points [x, y, z].
    zones, points : list or None
        As in a scene; None if unchanged.
    path : dict or None
        A new path as in a scene.
    changes : list of dict or None
        All changes to date as in ``flight.json``, if one is new or has received its path.
    """

    time_s: float
    aircraft: dict[str, float]
    speed_m_s: float
    clearance_m: float
    kind: str
    trail: list[list[float]]
    versions: list[tuple[str, list[list[float]]]]
    said: list[str]
    zones: list[dict[str, Any]] | None
    points: list[dict[str, Any]] | None
    path: dict[str, Any] | None
    changes: list[dict[str, Any]] | None


@dataclass(frozen=True)
class Landed:
    """The end of a flight that is not saved yet; ``outcome`` is as in ``flight.json``."""

    outcome: dict[str, Any]


def fly(task: FlyTask, connection: Connection, sender: Sender) -> None:
    """Fly a plan, send its updates, and save ``flight.json`` with its pictures."""
    from pathgene.host.flight.flight import PERIOD_S
    from pathgene.host.replanning.fly import save, underway
    from pathgene.host.replanning.scenario import Scenario
    from pathgene.host.report.read import read_run
    from pathgene.host.report.run_files import SUMMARY

    orders: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(connection, orders), daemon=True).start()
    planned = read_run(task.folder / SUMMARY)
    said: list[str] = []
    with underway(
        planned.problem,
        planned.path,
        Scenario(),
        planner=task.planner,
        board=task.board,
        seed=task.seed,
        say=said.append,
    ) as (session, report):
        watch = _Watch(session, said)
        sender.send(watch.look())
        speed, owed_s, seen_s = USUAL, 0.0, time.monotonic()
        while not session.ended:
            flown = 0
            while not orders.empty():
                order = orders.get()
                if order == STOP:
                    sender.send(Failed(ENDED))
                    return
                if isinstance(order, Speed):
                    speed = order.factor
                elif not session.ended:
                    said += _heeded(session, order)
                    # It happens now, even if time is stopped.
                    session.step()
                    flown += 1
            now_s = time.monotonic()
            owed_s += speed * min(now_s - seen_s, _LONGEST_S)
            seen_s = now_s
            while owed_s >= PERIOD_S and not session.ended:
                session.step()
                flown += 1
                owed_s -= PERIOD_S
                # A plan on the simulated gates takes longer here than in the air.
                if time.monotonic() - now_s > _LONGEST_S:
                    owed_s = 0.0
            if flown:
                sender.send(watch.look())
            time.sleep(max(0.0, _PERIOD_S - (time.monotonic() - now_s)))
        landed = report()
    sender.send(Landed(landed.outcome.to_dict()))
    try:
        save(landed, task.folder)
    except OSError as error:
        sender.send(Failed(f"The flight is not saved: {error.strerror or error}."))
    else:
        sender.send(Saved([]))


def _listen(connection: Connection, orders: queue.SimpleQueue[Any]) -> None:
    """Pass on the orders of the desk; the end of the desk is an order to stop."""
    with contextlib.suppress(EOFError, OSError):
        while True:
            orders.put(connection.recv())
    orders.put(STOP)


def _heeded(session: Session, order: Any) -> list[str]:
    """Apply an order; return the reason if that is impossible."""
    from pathgene.host.replanning.scenario import Scenario, check_mission

    event = _event(session, order)
    if event is None:
        return ["No zone has appeared."]
    try:
        check_mission(session.mission, Scenario((event,)))
    except InputError as error:
        return [str(error)]
    session.happen(event)
    return []


def _event(session: Session, order: Any) -> Event | None:
    """Return the event for an order, or None."""
    from pathgene.host.replanning.scenario import Event, NewZone, Placed

    if order == AHEAD:
        turn_m, terrain = session.mission.limits.turn_radius_m, session.mission.terrain
        size_m = max(terrain.width_m, terrain.height_m)
        radius_m = round(max(_RADIUS * turn_m, _SHARE * size_m), -1)
        return Event(0.0, (NewZone(Placed("path", radius_m, radius_m + _AWAY * turn_m)),))
    if order == CLEAR:
        known = {zone.name for zone in session.mission.zones}
        names = dict.fromkeys(zone.name for zone in session.airspace.past[-1][1])
        gone = tuple(name for name in names if name not in known)
        return Event(0.0, gone=gone) if gone else None
    if isinstance(order, Goal):
        ground, first = session.mission.terrain.ground, session.mission.goal
        height_m = first[2] - float(ground(*first[:2]))
        z = float(ground(order.x_m, order.y_m)) + height_m
        return Event(0.0, goal=(order.x_m, order.y_m, z))
    return Event(0.0, (NewZone(order),))


class _Watch:
    """Collects the news of a flight."""

    def __init__(self, session: Session, said: list[str]) -> None:
        self._session, self._said = session, said
        self._samples = self._legs = self._active = self._changes = 0
        self._past = 0
        self._goal: Point | None = None

    def look(self) -> Flown:
        """Return the news since the previous call."""
        from pathgene.host.terrain.surface import surface_below
        from pathgene.host.web.scene import zones_scene

        session = self._session
        pilot, air = session.pilot, session.airspace
        state, now = pilot.flight.state, pilot.time_s
        samples = pilot.samples[self._samples :: _EVERY]
        self._samples += _EVERY * len(samples)
        legs = pilot.legs[self._legs :]
        self._legs += len(legs)
        zones = None
        if len(air.past) > self._past:
            self._past = len(air.past)
            zones = zones_scene(air.past[-1][1])
        said = self._said[:]
        self._said.clear()
        here = np.array([state.x]), np.array([state.y])
        ground = float(surface_below(session.mission.terrain, *here, void_m=math.nan)[0])
        path, changes = self._new()
        return Flown(
            time_s=now,
            aircraft={
                "x": state.x,
                "y": state.y,
                "z": state.z,
                "heading_deg": pilot.pose().heading_deg,
            },
            speed_m_s=pilot.ground_speed_m_s,
            clearance_m=state.z - ground,
            kind=pilot.kind,
            trail=[_rounded(sample[1:4]) for sample in samples],
            versions=[(leg.kind, self._points(leg)) for leg in legs],
            said=said,
            zones=zones,
            points=self._ends(),
            path=path,
            changes=changes,
        )

    def _new(self) -> tuple[dict[str, Any] | None, list[dict[str, Any]] | None]:
        """Return the path that has become active since the previous call, and the changes."""
        from pathgene.host.web.scene import path_scene

        changes = self._session.changes
        done = [change for change in changes if change.active_s is not None]
        if (len(changes), len(done)) == (self._changes, self._active):
            return None, None
        path = None
        if len(done) > self._active:
            _, attempt = done[-1].attempts[-1]
            plan = attempt.plan
            assert plan is not None
            path = path_scene(plan.evaluator, plan.path, attempt.planner)
        self._changes, self._active = len(changes), len(done)
        return path, [change.to_dict() for change in changes]

    def _ends(self) -> list[dict[str, Any]] | None:
        """Return the ends if the goal has changed, which includes the first call."""
        from pathgene.host.web.scene import points_scene

        goal = self._session.airspace.goal
        if goal == self._goal:
            return None
        self._goal = goal
        mission = self._session.mission
        return points_scene(dataclasses.replace(mission, goal=goal, zones=()))

    def _points(self, leg: Leg) -> list[list[float]]:
        from pathgene.host.evaluation.track import SmoothedTrack
        from pathgene.host.replanning.tracks import part

        # A circle has many rounds.
        track = leg.track if leg.kind == "path" else part(leg.track, 0.0, _SHOWN_M)
        samples = SmoothedTrack(track, self._session.mission.terrain).sample(_STEP_M)
        return [_rounded(each) for each in zip(samples.x, samples.y, samples.z, strict=True)]


def _rounded(point: Sequence[float]) -> list[float]:
    return [round(float(each), 1) for each in point]
