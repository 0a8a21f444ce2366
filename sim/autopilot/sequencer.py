"""The mission, item by item: which one is flown, when it is done, and the next one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from pathgene.sim.autopilot.items import FRAMES, Command, Frame, Item, has_place
from pathgene.sim.autopilot.places import Vector
from pathgene.sim.autopilot.targets import Air, Step, Target


__all__ = ["Navigator", "Sequencer"]

# A loiter to an altitude is done this close to it.
_AT_ALTITUDE_M = 5.0
_MOST_JUMPS = 100
# Height above home of a go-around that names none.
_ABORT_M = 30.0
# An item to continue and climb pushes its target ahead by this distance.
_AHEAD_M = 300.0


class Navigator(Protocol):
    """Leg and loiter of an autopilot; see :class:`PlaneNavigator` and :class:`Px4Navigator`."""

    previous: Target
    next: Target

    def enter(self, air: Air) -> None:
        """Begin a mission here."""

    def set_next(self, target: Target, air: Air, after: Vector | None) -> None:
        """Make a target of a mission the next one."""

    def go_to(self, target: Target, air: Air) -> None:
        """Fly straight to a target and loiter there."""

    def break_leg(self) -> None:
        """Forget the leg."""

    def steer_leg(self, air: Air, dt_s: float) -> float:
        """Return the acceleration to the right along the leg."""

    def steer_loiter(self, air: Air, dt_s: float) -> float:
        """Return the acceleration to the right around the target."""

    def arrival(self, air: Air, acceptance_m: float) -> str | None:
        """Return how the waypoint was reached, or None."""

    def height_m(self, air: Air) -> float:
        """Return the altitude to ask for."""

    def land(self, air: Air, dt_s: float) -> tuple[Step, bool]:
        """Return the demands of a landing, and whether the aircraft is about to touch down."""

    @property
    def is_on_circle(self) -> bool:
        """True while the aircraft flies the circle of a loiter."""


@dataclass
class _Progress:
    """The item under way, and its progress."""

    index: int
    item: Item
    begun_s: float
    circled_s: float | None = None
    turned_rad: float = 0.0
    bearing_rad: float = math.nan
    at_altitude: bool = False
    course: Vector = (0.0, 1.0)
    climbs_to_m: float | None = None


@dataclass
class Sequencer:
    """A mission under way.

    The items come from the autopilot's list and are read when each begins, so an upload in flight
    changes the items to come and leaves the present one.

    Parameters
    ----------
    items : callable
        Returns the present list; item 0 is home for ArduPlane.
    first : int
        Number of the first item that is flown.
    say : callable
        Takes a text for the ground station.

    Attributes
    ----------
    reached : list of int
        Numbers of the items that have been done.
    speed_m_s : float or None
        Airspeed that the mission asked for.
    resumes : int
        Number of the item that the mission begins with, or resumes with after another mode. A new
        list does not change it, so another mission is resumed in its middle.
    is_complete, has_landed, returns : bool
        Whether nothing is left to fly, whether the aircraft is on the ground, and whether the
        mission ended with a return.
    """

    items: Callable[[], Sequence[Item]]
    navigator: Navigator
    first: int
    say: Callable[[str], None]
    reached: list[int] = field(default_factory=list)
    speed_m_s: float | None = None
    is_complete: bool = False
    has_landed: bool = False
    returns: bool = False
    resumes: int = field(init=False)
    _now: _Progress | None = None
    _jumps: dict[int, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.resumes = self.first

    @property
    def index(self) -> int:
        """Number of the item under way, or of the one to begin with."""
        return self.resumes if self._now is None else self._now.index

    @property
    def command(self) -> int | None:
        """Command of the item under way."""
        return None if self._now is None else self._now.item.command

    @property
    def is_running(self) -> bool:
        """True while an item is under way."""
        return self._now is not None

    def start(self, air: Air, now_s: float, index: int | None = None) -> None:
        """Begin or resume the mission, or begin it at an item, at the present place."""
        self.navigator.enter(air)
        self.is_complete = False
        self._jumps.clear()
        if index is None:
            index = self.resumes if self.resumes < len(self.items()) else self.first
        self._begin_from(index, air, now_s)

    def choose(self, index: int) -> None:
        """Let the mission begin at an item the next time; one that is paused is forgotten."""
        self._now = None
        self.is_complete = False
        self.resumes = max(index, self.first)

    def jump(self, index: int, air: Air, now_s: float) -> bool:
        """Continue with another item; return whether the mission has it."""
        if not 0 <= index < len(self.items()):
            return False
        self.is_complete = False
        self._begin_from(max(index, self.first), air, now_s)
        return True

    def step(self, air: Air, now_s: float, dt_s: float) -> Step | None:
        """Return the demands for now, or None if the mission is complete."""
        if self._now is None:
            return None
        step, done = self._fly(self._now, air, now_s, dt_s)
        if done:
            self.reached.append(self._now.index)
            again = self._now.climbs_to_m is not None
            index = self._approach_start() if again else self._now.index + 1
            self._begin_from(index, air, now_s)
        return step

    def climb_away(self, home_m: float) -> None:
        """Break a landing off: climb straight ahead, then begin the approach again."""
        now = self._now
        if now is not None:
            above_m = now.item.params[0] if now.item.params[0] > 0 else _ABORT_M
            now.climbs_to_m = home_m + above_m
            (x, y), (to_x, to_y) = self.navigator.previous.place, self.navigator.next.place
            length = math.hypot(to_x - x, to_y - y) or 1.0
            now.course = (to_x - x) / length, (to_y - y) / length

    def _approach_start(self) -> int:
        """Return the item that begins an approach, or the one before the landing."""
        items = self.items()
        found = (n for n, item in enumerate(items) if item.command == Command.DO_LAND_START)
        return next(found, self.index - 1)

    def _begin_from(self, index: int, air: Air, now_s: float) -> None:
        """Begin the first item from ``index`` on that flies somewhere."""
        items = self.items()
        jumps = 0
        while index < len(items) and not items[index].navigates:
            target = self._do(index, items[index])
            jumps += target is not None
            index = index + 1 if target is None or jumps > _MOST_JUMPS else target
        self.returns = index < len(items) and items[index].command == Command.RTL
        if index >= len(items) or self.returns:
            self._now = None
            self.is_complete = True
            self.resumes = self.first
            return
        item = items[index]
        self.resumes = index
        self._now = _Progress(index, item, now_s, course=air.motion.nose)
        self.say(f"Mission: {index} {_NAMES.get(item.command, 'item')}")
        if item.command == Command.DELAY:
            return
        after = next((later for later in items[index + 1 :] if later.navigates), None)
        place = None if after is None or not has_place(after) else _place(after, air)
        self.navigator.set_next(_target(item, air), air, place)
        for later in range(index + 1, len(items)):
            if items[later].navigates or items[later].command == Command.DO_JUMP:
                break
            self._do(later, items[later])

    def _do(self, index: int, item: Item) -> int | None:
        """Carry out an item that does not fly; return the item to continue with, or None."""
        if item.command == Command.DO_JUMP:
            done = self._jumps.get(index, 0)
            if item.params[1] < 0 or done < item.params[1]:
                self._jumps[index] = done + 1
                return int(item.params[0])
        elif item.command == Command.DO_CHANGE_SPEED and item.params[0] == 0:
            # Speed type 0 is airspeed; ground speed is not followed here.
            self.speed_m_s = item.params[1] if item.params[1] > 0 else self.speed_m_s
        return None

    def _fly(self, now: _Progress, air: Air, now_s: float, dt_s: float) -> tuple[Step, bool]:
        """Return the demands of an item, and whether it is done."""
        navigator, item = self.navigator, now.item
        match item.command:
            case Command.WAYPOINT:
                steer = navigator.steer_leg(air, dt_s)
                how = navigator.arrival(air, max(item.params[1], 0.0))
                if how is not None:
                    gap = math.dist(air.place, navigator.next.place)
                    self.say(f"{how} waypoint #{now.index} dist {int(gap)}m")
                return Step(steer, navigator.height_m(air)), how is not None
            case Command.TAKEOFF:
                return self._take_off(now, air)
            case Command.LAND if now.climbs_to_m is not None:
                return self._climb_away(now, air, dt_s)
            case Command.LAND:
                return self._land(air, dt_s)
            case Command.CONTINUE_AND_CHANGE_ALT:
                return self._continue(now, air, dt_s)
            case Command.DELAY:
                steer = navigator.steer_loiter(air, dt_s)
                done = now_s - now.begun_s >= item.params[0]
                return Step(steer, navigator.height_m(air)), done
        steer = navigator.steer_loiter(air, dt_s)
        step = Step(steer, navigator.height_m(air))
        self._count_turns(now, air, now_s)
        return step, self._has_loitered(now, air, now_s)

    def _count_turns(self, now: _Progress, air: Air, now_s: float) -> None:
        """Note the angle flown around the loiter, and its altitude."""
        if not self.navigator.is_on_circle and now.circled_s is None:
            return
        if now.circled_s is None:
            now.circled_s = now_s
        (x, y), (centre_x, centre_y) = air.place, self.navigator.next.place
        bearing = math.atan2(centre_x - x, centre_y - y)
        if math.isfinite(now.bearing_rad):
            now.turned_rad += abs(math.remainder(bearing - now.bearing_rad, 2 * math.pi))
        now.bearing_rad = bearing
        wanted = self.navigator.next.altitude_m(air.earth, air.place)
        now.at_altitude |= abs(air.altitude_m - wanted) < _AT_ALTITUDE_M

    def _has_loitered(self, now: _Progress, air: Air, now_s: float) -> bool:
        item = now.item
        if now.circled_s is None:
            return False
        match item.command:
            case Command.LOITER_TURNS:
                is_over = now.turned_rad >= 2 * math.pi * item.params[0]
            case Command.LOITER_TIME:
                is_over = now_s - now.circled_s >= item.params[0]
            case Command.LOITER_TO_ALT:
                is_over = now.at_altitude
            case _:
                return False
        return is_over and self._points_on(now, air)

    def _points_on(self, now: _Progress, air: Air) -> bool:
        """Return whether the aircraft points at the next item, which ends a loiter."""
        items = self.items()
        after = next((item for item in items[now.index + 1 :] if item.navigates), None)
        if after is None or not has_place(after):
            return True
        (x, y), (to_x, to_y) = air.place, _place(after, air)
        east, north = air.motion.velocity
        angle = math.atan2(to_x - x, to_y - y) - math.atan2(east, north)
        return abs(math.remainder(angle, 2 * math.pi)) < math.radians(10)

    def _take_off(self, now: _Progress, air: Air) -> tuple[Step, bool]:
        wanted = self.navigator.next.altitude_m(air.earth, air.place)
        pitch = math.radians(now.item.params[0] if now.item.params[0] > 0 else 10.0)
        done = air.altitude_m >= wanted
        if done:
            self.say(f"Takeoff complete at {air.altitude_m - air.earth.home_m:.2f}m")
            self.navigator.break_leg()
        # Wings level on the course of the launch.
        return Step(0.0, wanted, pitch, 1.0), done

    def _land(self, air: Air, dt_s: float) -> tuple[Step, bool]:
        step, is_low = self.navigator.land(air, dt_s)
        ground = self.navigator.next.altitude_m(air.earth, air.place)
        self.has_landed = is_low and air.altitude_m <= max(ground, air.earth.ground(air.place))
        return step, self.has_landed

    def _climb_away(self, now: _Progress, air: Air, dt_s: float) -> tuple[Step, bool]:
        wanted = now.climbs_to_m or 0.0
        self._push_ahead(now, air, wanted)
        done = air.altitude_m >= wanted - _AT_ALTITUDE_M
        return Step(self.navigator.steer_leg(air, dt_s), wanted), done

    def _push_ahead(self, now: _Progress, air: Air, wanted: float) -> None:
        """Move the target ahead on the course."""
        (x, y), (east, north) = air.place, now.course
        self.navigator.next = Target((x + _AHEAD_M * east, y + _AHEAD_M * north), wanted)

    def _continue(self, now: _Progress, air: Air, dt_s: float) -> tuple[Step, bool]:
        wanted = self.navigator.next.altitude_m(air.earth, air.place)
        self._push_ahead(now, air, wanted)
        gap = air.altitude_m - wanted
        way = now.item.params[0]
        done = gap >= 0 if way == 1 else gap <= 0 if way == 2 else abs(gap) <= _AT_ALTITUDE_M
        return Step(self.navigator.steer_leg(air, dt_s), wanted), done


_NAMES: dict[int, str] = {
    Command.WAYPOINT: "WP",
    Command.LOITER: "LoitUnlim",
    Command.LOITER_TURNS: "LoitTurns",
    Command.LOITER_TIME: "LoitTime",
    Command.LAND: "Land",
    Command.TAKEOFF: "Takeoff",
    Command.CONTINUE_AND_CHANGE_ALT: "ContinueAndChangeAlt",
    Command.LOITER_TO_ALT: "LoiterToAltitude",
    Command.DELAY: "Delay",
}


def _place(item: Item, air: Air) -> Vector:
    return air.earth.plane.local(item.lat, item.lon)


def _target(item: Item, air: Air) -> Target:
    """Return the target of an item."""
    frame = FRAMES.get(item.frame, Frame.AMSL)
    place, z_m = air.place, item.z
    if has_place(item) and item.command != Command.CONTINUE_AND_CHANGE_ALT:
        place = _place(item, air)
    radius = item.params[1] if item.command == Command.LOITER_TO_ALT else item.params[2]
    if item.command in (Command.WAYPOINT, Command.TAKEOFF, Command.LAND):
        radius = 0.0
    radius = radius if math.isfinite(radius) else 0.0
    return Target(place, z_m, frame, abs(radius), radius >= 0, item.command == Command.LAND)
