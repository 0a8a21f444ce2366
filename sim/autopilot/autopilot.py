"""The simulated autopilot: ``handle(message, now)`` and ``advance(now)``, in any kind of time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from pathgene.sim.autopilot.airframe import SIMULATED_PLANE, Airframe, eas2tas
from pathgene.sim.autopilot.commands import Commands
from pathgene.sim.autopilot.controlled import CommandResult
from pathgene.sim.autopilot.craft import Craft
from pathgene.sim.autopilot.feasibility import refusal
from pathgene.sim.autopilot.fence import Fence
from pathgene.sim.autopilot.items import DEGREES, FENCE, FRAMES, MISSION, RALLY, Frame, Item
from pathgene.sim.autopilot.lists import Lists
from pathgene.sim.autopilot.parameters import ARDUPLANE, PX4, Parameters
from pathgene.sim.autopilot.parameters import SIMULATED_PLANE as SIMULATED_PARAMETERS
from pathgene.sim.autopilot.pilot import Kind, Mode, Pilot, start_vehicle
from pathgene.sim.autopilot.places import Plane, distance
from pathgene.sim.autopilot.rules import ARDUPLANE_RULES, PX4_RULES
from pathgene.sim.autopilot.targets import Earth, Target
from pathgene.sim.autopilot.telemetry import Telemetry
from pathgene.sim.autopilot.vehicle import PERIOD_S, Vehicle
from pathgene.sim.autopilot.wind import Wind


__all__ = ["Autopilot", "Start", "parameters_of"]

_TEXT = 50
# Bits of FENCE_TYPE.
_ALTITUDE, _AREAS = 1, 4
# Values of FENCE_ACTION and GF_ACTION that return home, and PX4's that circles.
_RTL = {Kind.ARDUPLANE: (1,), Kind.PX4: (3,)}
_HOLD = {Kind.ARDUPLANE: (), Kind.PX4: (2,)}


@dataclass(frozen=True)
class Start:
    """Where a flight begins.

    Parameters
    ----------
    home : (float, float, float)
        Latitude, longitude and altitude AMSL.
    offset_m : (float, float)
        East and north of home.
    height_m : float
        Over home.
    heading_deg : float
        Clockwise from north.
    armed : bool
        Whether the motors run, and the aircraft is in the air.
    """

    home: tuple[float, float, float]
    offset_m: tuple[float, float] = (0.0, 0.0)
    height_m: float = 100.0
    heading_deg: float = 0.0
    armed: bool = True


def parameters_of(kind: Kind) -> Parameters:
    """Return the parameters of ArduPilot's simulated plane, or PX4's defaults."""
    if kind is Kind.ARDUPLANE:
        return Parameters(ARDUPLANE, SIMULATED_PARAMETERS)
    return Parameters(PX4)


class Autopilot:
    """An autopilot with its aircraft.

    It has no clock and no transport. :meth:`handle` takes a message and returns the answers;
    :meth:`advance` flies up to an instant and returns its unrequested messages.

    Parameters
    ----------
    parameters : Parameters, optional
        By default :func:`parameters_of` its kind.
    ground : callable, optional
        Returns the altitude of the ground at a latitude and longitude; home's by default.
    craft : callable, optional
        Returns another aircraft than ``airframe`` in ``wind``, on a plane around home.

    Attributes
    ----------
    lists : Lists
        Mission, fence and rally points.
    pilot : Pilot
        The flying part.
    armed : bool
        Whether the motors run.
    reached : list of int
        Numbers of the mission's items that have been done.
    booted_s : float
        Instant of the latest start, from which its clock counts.
    """

    def __init__(
        self,
        kind: Kind,
        start: Start,
        *,
        parameters: Parameters | None = None,
        airframe: Airframe = SIMULATED_PLANE,
        wind: Wind | None = None,
        ground: Callable[[float, float], float] | None = None,
        craft: Callable[[Plane], Craft] | None = None,
        system: int = 1,
    ) -> None:
        self.kind = kind
        self.system, self.component = system, 1
        self.parameters = parameters_of(kind) if parameters is None else parameters
        self._out: list[Any] = []
        lat, lon, home_m = start.home
        plane = Plane(lat, lon)
        self.earth = Earth(
            plane,
            home_m,
            (lambda _place: home_m)
            if ground is None
            else (lambda place: ground(*plane.degrees(place))),
        )
        self.lists = Lists(
            ARDUPLANE_RULES if kind is Kind.ARDUPLANE else PX4_RULES,
            runs=lambda: self.pilot.mode is Mode.AUTO,
            say=self.say,
            changed=self._list_changed,
        )
        self.pilot = Pilot(
            kind,
            self.parameters,
            self._small_aircraft(start, airframe, wind) if craft is None else craft(plane),
            self.earth,
            lambda: self.lists.items[MISSION],
            self.say,
        )
        self.pilot.return_target = self._return_target
        self.armed = start.armed
        self.lists.current = lambda: self.pilot.sequencer.index
        self.lists.chosen = self.set_current
        if kind is Kind.ARDUPLANE:
            place = round(lat * DEGREES), round(lon * DEGREES)
            self.lists.home = Item(16, 0, (0.0,) * 4, *place, home_m)
        self._fence = Fence()
        self._is_breached = False
        self._told = self._texts = 0
        self._time_s = 0.0
        self._boots_s = -math.inf
        self.booted_s = 0.0
        self._commands = Commands(self)
        self._telemetry = Telemetry(self)

    def _small_aircraft(self, start: Start, airframe: Airframe, wind: Wind | None) -> Vehicle:
        """Return the simulated aircraft in level flight at its cruise speed."""
        altitude = self.earth.home_m + start.height_m
        name = "AIRSPEED_CRUISE" if self.kind is Kind.ARDUPLANE else "FW_AIRSPD_TRIM"
        return start_vehicle(
            self.kind,
            self.parameters,
            airframe,
            Wind() if wind is None else wind,
            place=(*start.offset_m, altitude),
            heading_rad=math.radians(start.heading_deg),
            airspeed_m_s=self.parameters[name] * eas2tas(altitude) ** airframe.pitot_exponent,
        )

    @property
    def time_s(self) -> float:
        """Instant up to which the autopilot has flown."""
        return self._time_s

    @property
    def reached(self) -> list[int]:
        """Numbers of the mission's items that have been done."""
        return self.pilot.sequencer.reached

    def restart(self, silent_s: float, *, keeps_lists: bool = True) -> None:
        """Restart, as after a failure of its power; it is silent for a while.

        Uploads under way are forgotten. Lists stay in its storage if it has one: an ArduPilot then
        holds the items of a mission that have arrived.
        """
        self._boots_s = self.booted_s = self._time_s + silent_s
        self.lists.restart(keeps=keeps_lists)
        self.armed = False
        self.pilot.sequencer.choose(0)
        self._out.clear()

    def say(self, text: str) -> None:
        """Send a text to the ground station; a long one is sent in parts with a common number."""
        packed = text.encode()
        parts = [packed[i : i + _TEXT] for i in range(0, len(packed), _TEXT)]
        self._texts += len(parts) > 1
        number = self._texts if len(parts) > 1 else 0
        for place, part in enumerate(parts):
            self._out.append(
                mavlink.MAVLink_statustext_message(6, part, id=number, chunk_seq=place)
            )

    def tell(self, number: int) -> CommandResult:
        """Send the message of a number, of which the state of the mission is known here."""
        if number != mavlink.MAVLINK_MSG_ID_MISSION_CURRENT:
            return CommandResult.UNSUPPORTED
        self._out.append(self._telemetry.mission_current())
        return CommandResult.ACCEPTED

    def handle(self, message: Any, now_s: float) -> list[Any]:
        """Return the answers to a message of a ground station.

        Parameters
        ----------
        message : MAVLink message of pymavlink
            Its header names the sender. A message for another system is ignored.
        now_s : float
            The present instant, for the timeouts of uploads.
        """
        is_for_another = getattr(message, "target_system", self.system) not in (0, self.system)
        if is_for_another or now_s < self._boots_s:
            return []
        answers = self.lists.handle(message, now_s)
        answers += self._commands.handle(message)
        return [*answers, *self._sent()]

    def advance(self, now_s: float) -> list[Any]:
        """Fly up to an instant and return the messages that nobody asked for."""
        out = self.lists.tick(now_s)
        if now_s < self._boots_s:
            self._time_s = max(self._time_s, now_s)
            return []
        while self._time_s + PERIOD_S <= now_s + 1e-9:
            self._time_s += PERIOD_S
            if self.armed:
                self.pilot.tick()
                self._watch_fence()
                if self.pilot.mode is Mode.LANDED:
                    self.armed = False
            out += self._sent()
            out += self._tell_reached()
            out += self._telemetry.due(self._time_s)
        return out + self._sent()

    def fly_mission(self) -> CommandResult:
        """Begin or resume the mission; PX4 refuses one that is not feasible."""
        first = self.pilot.sequencer.first
        items = self.lists.items[MISSION]
        if len(items) <= first:
            return CommandResult.DENIED
        if self.mission_refusal() is not None:
            self.say("Mode change refused: no valid mission")
            return CommandResult.DENIED
        self._told = len(self.reached)
        self.pilot.fly_mission()
        return CommandResult.ACCEPTED

    def mission_refusal(self) -> str | None:
        """Return why the mission will not start, or None."""
        if self.kind is not Kind.PX4 or not self.lists.items[MISSION]:
            return None
        return refusal(self.lists.items[MISSION], self.parameters, self.earth.home_m)

    def set_current(self, index: int) -> bool:
        """Continue the mission with another item; return whether it has it."""
        if not 0 <= index < len(self.lists.items[MISSION]):
            return False
        if self.pilot.mode is Mode.AUTO:
            return self.pilot.sequencer.jump(index, self.pilot.air(), self.pilot.time_s)
        self.pilot.sequencer.choose(index)
        return True

    def return_home(self, reason: str) -> None:
        """Fly to home, or to the nearest rally point that is closer, and circle there."""
        self.pilot.return_home(self._return_target(), reason)

    def _return_target(self) -> Target:
        """Return home or the nearest rally point within ``RALLY_LIMIT_KM``."""
        home = self.pilot.home_target()
        points = self.lists.items[RALLY]
        if self.kind is not Kind.ARDUPLANE or not points:
            return home
        here = self.pilot.vehicle.place
        plane = self.earth.plane
        rally = [
            Target(plane.local(item.lat, item.lon), item.z, FRAMES.get(item.frame, Frame.HOME))
            for item in points
        ]
        best = min(rally, key=lambda target: distance(target.place, here))
        limit = self.parameters["RALLY_LIMIT_KM"] * 1000
        far = distance(best.place, here)
        if limit > 0 and far > limit and far > distance(home.place, here):
            return home
        return replace(best, radius_m=home.radius_m, clockwise=home.clockwise)

    def _list_changed(self, kind: int) -> None:
        if kind == FENCE:
            self._fence = Fence.of(self.lists.items[FENCE], self.earth.plane)
            self._is_breached = False
        elif kind == MISSION and not self.lists.is_receiving(MISSION):
            if not self.lists.items[MISSION] and self.pilot.mode is not Mode.AUTO:
                self.pilot.sequencer.choose(0)
            reason = self.mission_refusal()
            if reason is not None:
                self.say(reason)

    def _watch_fence(self) -> None:
        """Break the flight off when the aircraft leaves the fence."""
        get = self.parameters
        if self.kind is Kind.ARDUPLANE:
            bits = int(get["FENCE_TYPE"]) if get["FENCE_ENABLE"] else 0
            action = int(get["FENCE_ACTION"])
        else:
            bits, action = _AREAS, int(get["GF_ACTION"])
        vehicle = self.pilot.vehicle
        above_home = vehicle.altitude_m - self.earth.home_m
        breached = bool(bits & _AREAS) and self._fence.breached(vehicle.place)
        if self.kind is Kind.ARDUPLANE and bits & _ALTITUDE:
            breached |= above_home > get["FENCE_ALT_MAX"]
        if breached and not self._is_breached:
            self.say("Fence breached")
            if action in _RTL[self.kind]:
                self.return_home("Fence breach, changing mode to RTL")
            elif action in _HOLD[self.kind]:
                self.pilot.guide(Target(vehicle.place, vehicle.altitude_m), Mode.IDLE)
        self._is_breached = breached

    def _tell_reached(self) -> list[Any]:
        new = self.reached[self._told :]
        self._told = len(self.reached)
        return [mavlink.MAVLink_mission_item_reached_message(number) for number in new]

    def _sent(self) -> list[Any]:
        out, self._out = self._out, []
        return out
