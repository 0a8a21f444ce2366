"""Flight of a mission file over a terrain: commands are carried out, and jumps unrolled."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

from pathgene.host.errors import InputError
from pathgene.host.formats.mission_items import MissionFile, MissionItem
from pathgene.host.mission.foreign.commands import (
    CIRCLES,
    IGNORED,
    Command,
    named,
    radius_place,
)
from pathgene.host.mission.foreign.course import Chain, Point
from pathgene.host.mission.foreign.home import (
    SAME_HEIGHT_M,
    HomePlace,
    Surroundings,
    check_size,
)
from pathgene.host.mission.foreign.track import TOLERANCE_M
from pathgene.host.remarks import Grade, Remark


__all__ = ["Aims", "Flight", "flight_of"]

# A jump that is repeated more often flies no other legs.
_MOST_REPEATS = 2
_MOST_VISITS = 20_000
_FLOWN = frozenset(Command)
# ArduPlane returns to a rally point within this distance.
_RALLY_M = 5000.0
# Share of the steepest climb with which a take-off without a place climbs.
_TAKEOFF_SHARE = 0.9
# A speed beyond the aircraft's cruise speed by less than this is the cruise speed.
_SAME_SPEED = 1.02
# Speeds beyond this are slips.
_MOST_M_S = 1000.0


@dataclass(frozen=True)
class Aims:
    """The aircraft's part in a flight.

    Parameters
    ----------
    radius_m : float
        Radius of its turns over the ground.
    speed_m_s : float
        Cruise speed.
    climb : float
        Tangent of its steepest climb.
    return_m : float
        Height above home of a return to launch.
    """

    radius_m: float
    speed_m_s: float
    climb: float
    return_m: float


@dataclass(frozen=True)
class Flight:
    """A mission as it is flown.

    Parameters
    ----------
    chains : tuple of Chain
        Its chains.
    ignored : tuple of str
        Items that do not move the aircraft, in words.
    remarks : tuple of Remark
        Sentences on assumptions.
    returns : bool
        The mission returns to launch at the height of the return.
    """

    chains: tuple[Chain, ...]
    ignored: tuple[str, ...]
    remarks: tuple[Remark, ...]
    returns: bool


def flight_of(mission: MissionFile, around: Surroundings, aims: Aims) -> Flight:
    """Return the flight of a mission.

    Raises
    ------
    InputError
        If an item cannot be judged; the sentence has its number and command.
    """
    return _Builder(mission, around, aims).flight()


@dataclass
class _Builder:
    """Carries out the items in flying order."""

    mission: MissionFile
    around: Surroundings
    aims: Aims
    chains: list[Chain] = field(default_factory=list)
    points: list[Point] = field(default_factory=list)
    remarks: list[Remark] = field(default_factory=list)
    ignored: dict[int, str] = field(default_factory=dict)
    speed: float = 1.0
    starts_low: bool = True
    is_over: bool = False
    returns: bool = False
    following: MissionItem | None = None

    def flight(self) -> Flight:
        """Return the flight; see :func:`flight_of`."""
        order = list(_flown(self.mission, self._say))
        following: list[MissionItem | None] = [None]
        for item in reversed(order):
            following.append(item if item.lat is not None else following[-1])
        for item, after in zip(order, following[-2::-1], strict=True):
            self.following = after
            if item.command in IGNORED:
                self.ignored[item.number] = named(item.command)
            elif item.command == Command.DO_CHANGE_SPEED:
                self._change_speed(item)
            elif item.command != Command.DO_LAND_START:
                self._fly(item)
        self._end()
        if not self.chains:
            raise InputError("no item of the mission is flown.")
        ignored = tuple(
            f"{self.mission.word} {number} {name}" for number, name in self.ignored.items()
        )
        return Flight(tuple(self.chains), ignored, tuple(self.remarks), self.returns)

    def _say(self, text: str, grade: Grade = Grade.NOTE) -> None:
        remark = Remark(grade, text)
        if remark not in self.remarks:
            self.remarks.append(remark)

    def _end(self, *, returns: bool = False) -> None:
        """End the chain that is being flown."""
        if self.points:
            self.chains.append(Chain(tuple(self.points), self.starts_low, returns=returns))
        self.points = []

    def _fly(self, item: MissionItem) -> None:
        if self.is_over:
            self._say(
                f"{self.mission.word} {item.number} and later items, after the end of the mission, "
                "are judged as a flight of their own."
            )
            self.is_over, self.starts_low = False, False
        if item.command == Command.TAKEOFF:
            self._take_off(item)
        elif item.command == Command.RETURN_TO_LAUNCH:
            self._return(item)
        elif item.command == Command.LAND:
            place = replace(self._at(item), is_ground=True, is_free=True)
            self._compare(place, item)
            self._add(place)
            self._end()
            self.is_over = True
        elif item.command in CIRCLES:
            self._circle(item)
        else:
            self._add(self._at(item))

    def _add(self, point: Point) -> None:
        """Add a point, unless it is the last one again."""
        last = self.points[-1] if self.points else None
        if last is None or point.circle_m or math.dist(last.place, point.place) > TOLERANCE_M:
            self.points.append(replace(point, speed=self.speed))

    def _at(self, item: MissionItem) -> Point:
        """Return the place of an item."""
        name = f"{self.mission.word} {item.number}"
        x, y, z = self.around.place(item, name)
        return Point(x, y, z, name, ("item", item.number))

    def _compare(self, place: Point, item: MissionItem) -> None:
        """Warn of a landing above the ground; one in the ground is a fault."""
        ground_m = self.around.ground(place.x_m, place.y_m)
        if place.z_m > ground_m + SAME_HEIGHT_M:
            self._say(
                f"{place.name} ({named(item.command)}) is at {place.z_m:.1f} m, and the ground "
                f"there at {ground_m:.1f} m; the landing is judged down to {place.z_m:.1f} m only.",
                Grade.WARNING,
            )

    def _take_off(self, item: MissionItem) -> None:
        """Climb from home to the place of a take-off, or towards the next place without one."""
        home = self.around.home_needed()
        if not self.points:
            self.starts_low = True
            self._add(Point(home.x_m, home.y_m, home.z_m, "home", is_free=True, is_ground=True))
        if item.lat is not None:
            self._add(self._at(item))
            return
        last = self.points[-1]
        following = self.following
        name = f"{self.mission.word} {item.number}"
        z = self.around.altitude(item, name, last.x_m, last.y_m)
        if following is None:
            raise InputError(f"{name} ({named(item.command)}) has no place, and none follows.")
        to = self._at(following)
        run = math.hypot(to.x_m - last.x_m, to.y_m - last.y_m)
        needed = max(z - last.z_m, 0.0) / max(_TAKEOFF_SHARE * self.aims.climb, 1e-9)
        share = min(needed / run, 1.0) if run > 0 else 1.0
        x, y = (a + share * (b - a) for a, b in ((last.x_m, to.x_m), (last.y_m, to.y_m)))
        self._add(Point(x, y, z, name, ("item", item.number), is_free=True))
        self._say(
            f"{name} ({named(item.command)}) has no place; the aircraft is taken to climb towards "
            f"{self.mission.word} {following.number}."
        )

    def _circle(self, item: MissionItem) -> None:
        name = f"{self.mission.word} {item.number}"
        if item.lat is None and self.points:
            last = self.points[-1]
            z = self.around.altitude(item, name, last.x_m, last.y_m) if item.alt_m else last.z_m
            point = Point(last.x_m, last.y_m, z, name, ("item", item.number))
        else:
            point = self._at(item)
        stated = item.params[radius_place(item.command)]
        asked = abs(stated or 0.0)
        check_size(f"{name} ({named(item.command)})", "a radius", asked)
        is_tight = 0 < asked < self.aims.radius_m * self.speed**2
        self._add(
            replace(
                point,
                circle_m=max(asked, self.aims.radius_m * self.speed**2),
                asked_m=asked if is_tight else None,
                arrival="gentle" if item.command == Command.LOITER_TO_ALT else "linear",
                is_free=True,
            )
        )
        if item.command == Command.LOITER_UNLIM and self.following is not None:
            self._say(
                f"{name} ({named(item.command)}) circles without end; the items after it are "
                "judged as flown when the pilot continues the mission.",
                Grade.WARNING,
            )

    def _return(self, item: MissionItem) -> None:
        """Fly to home, or to the nearest rally point."""
        home = self.around.home_needed()
        target = self._rally(home)
        if target is None:
            z = home.z_m + self.aims.return_m
            target = Point(home.x_m, home.y_m, z, "home", ("return", 0))
            self.returns = True
        self._add(replace(target, arrival="return", is_free=True, circle_m=self.aims.radius_m))
        if len(self.points) > 1:
            self.points[-2] = replace(self.points[-2], is_free=True)
        self._say(
            f"{self.mission.word} {item.number} ({named(item.command)}) returns to {target.name} "
            f"at {target.z_m - home.z_m:g} m above home."
        )
        self._end(returns=True)
        self.is_over = True

    def _rally(self, home: HomePlace) -> Point | None:
        """Return the nearest rally point that is near enough, from the last point."""
        if not self.points:
            return None
        last, best = self.points[-1], None
        nearest = _RALLY_M
        for number, (lat, lon, height_m) in enumerate(self.mission.rally, start=1):
            x, y = self.around.local(f"rally point {number}", lat, lon)
            check_size(f"rally point {number}", "a height", height_m)
            away = math.hypot(x - last.x_m, y - last.y_m)
            if away <= nearest:
                nearest = away
                z = home.z_m + height_m
                best = Point(x, y, z, f"rally point {number}", ("rally", number))
        return best

    def _change_speed(self, item: MissionItem) -> None:
        wanted = item.params[1]
        if wanted is None or wanted <= 0:
            return
        if wanted > _MOST_M_S:
            raise InputError(
                f"{self.mission.word} {item.number} ({named(item.command)}) asks for {wanted:g} "
                f"m/s; the most is {_MOST_M_S:g} m/s, so mend the number."
            )
        share = wanted / self.aims.speed_m_s
        self.speed = share if share > _SAME_SPEED else 1.0
        if self.speed > 1:
            self._say(
                f"from {self.mission.word} {item.number} on, {wanted:g} m/s is above the cruise "
                f"speed of {self.aims.speed_m_s:g} m/s: turns are wider and climbs gentler."
            )


def _flown(mission: MissionFile, say: Callable[[str], None]) -> Iterator[MissionItem]:
    """Yield the items in flying order without jumps; a loop is flown two or three times."""
    items, word = mission.items, mission.word
    index = {item.number: place for place, item in enumerate(items)}
    done: dict[int, int] = {}
    place = visits = 0
    while place < len(items):
        item = items[place]
        visits += 1
        if visits > _MOST_VISITS:
            raise InputError(
                f"more than {_MOST_VISITS:,} items are flown, those that its jumps repeat "
                "included; split it."
            )
        place += 1
        if item.command != Command.DO_JUMP:
            if item.command not in IGNORED and item.command not in _FLOWN:
                raise InputError(
                    f"{word} {item.number} is {named(item.command)}, which cannot be judged; "
                    "leave it out or replace it by waypoints."
                )
            yield item
            continue
        target, count = item.params[0], item.params[1] or 0.0
        if target is None or target not in index:
            raise InputError(
                f"{word} {item.number} (DO_JUMP) leads to {word} {target or 0:g}, which is not in "
                "the mission."
            )
        if count < 0 and target <= item.number:
            say(
                f"{word} {item.number} (DO_JUMP) repeats {word} {target:g} to {item.number} "
                "without end; the items after it are judged as flown when the pilot continues."
            )
        most = 1 if count < 0 else min(count, _MOST_REPEATS)
        if done.get(item.number, 0) < most:
            done[item.number] = done.get(item.number, 0) + 1
            place = index[int(target)]
