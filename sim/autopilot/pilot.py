"""The flying part of the autopilot: mode, navigation and control of one aircraft, in ticks."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import Enum

from pathgene.sim.autopilot.airframe import GRAVITY_M_S2, Airframe
from pathgene.sim.autopilot.craft import Craft
from pathgene.sim.autopilot.height import Demand, Tecs, Vertical
from pathgene.sim.autopilot.items import Command, Item
from pathgene.sim.autopilot.lateral import Motion
from pathgene.sim.autopilot.parameters import Parameters
from pathgene.sim.autopilot.plane_navigator import PlaneNavigator
from pathgene.sim.autopilot.px4_height import Px4Height
from pathgene.sim.autopilot.px4_navigator import Px4Navigator
from pathgene.sim.autopilot.sequencer import Navigator, Sequencer
from pathgene.sim.autopilot.targets import Air, Earth, Step, Target
from pathgene.sim.autopilot.vehicle import PERIOD_S, Loops, Vehicle
from pathgene.sim.autopilot.wind import Wind


__all__ = ["Kind", "Mode", "Pilot", "loops_of", "start_vehicle"]


class Kind(Enum):
    """The autopilots that are simulated, by their values of MAV_AUTOPILOT."""

    ARDUPLANE = 3
    PX4 = 12


class Mode(Enum):
    """Modes of flight."""

    IDLE = "idle"
    AUTO = "auto"
    GUIDED = "guided"
    RTL = "rtl"
    LANDED = "landed"


class Pilot:
    """An aircraft with its navigation, ten ticks a second.

    Parameters
    ----------
    items : callable
        Returns the mission that the autopilot holds; item 0 is home for ArduPlane.
    say : callable
        Takes a text for the ground station.

    Attributes
    ----------
    time_s : float
        Seconds flown.
    mode : Mode
        Idle aircraft in the air circle where they are.
    return_target : callable
        Returns the place to which a mission returns; over home, if nobody knows rally points.
    """

    def __init__(
        self,
        kind: Kind,
        parameters: Parameters,
        vehicle: Craft,
        earth: Earth,
        items: Callable[[], Sequence[Item]],
        say: Callable[[str], None] = lambda _text: None,
    ) -> None:
        self.kind = kind
        self.parameters = parameters
        self.vehicle = vehicle
        self.earth = earth
        self.say = say
        self.mode = Mode.IDLE
        self.time_s = 0.0
        self.navigator: Navigator
        self._height: Tecs | Px4Height
        if kind is Kind.ARDUPLANE:
            self.navigator, self._height = PlaneNavigator(parameters), Tecs(parameters)
        else:
            self.navigator, self._height = Px4Navigator(parameters), Px4Height(parameters)
        first = 1 if kind is Kind.ARDUPLANE else 0
        self.sequencer = Sequencer(items, self.navigator, first, say)
        self.return_target: Callable[[], Target] = self.home_target
        self.bank_dem_rad = 0.0
        self.height_dem_m = vehicle.altitude_m
        self.guide(Target(vehicle.place, vehicle.altitude_m), Mode.IDLE)

    @property
    def height_delayed_m(self) -> float:
        """The demanded altitude that the height control follows."""
        return self._height.height_m

    @property
    def cruise_m_s(self) -> float:
        """The equivalent airspeed to hold."""
        name = "AIRSPEED_CRUISE" if self.kind is Kind.ARDUPLANE else "FW_AIRSPD_TRIM"
        return self.sequencer.speed_m_s or self.parameters[name]

    def air(self) -> Air:
        """Return the aircraft as navigation sees it."""
        vehicle = self.vehicle
        east, north, climb = vehicle.velocity
        nose = vehicle.nose
        wind_east, wind_north = vehicle.wind
        return Air(
            Motion(vehicle.place, (east, north), nose),
            vehicle.altitude_m,
            climb,
            (wind_east, wind_north),
            vehicle.sensed_tas_m_s,
            vehicle.eas2tas,
            self.earth,
        )

    def fly_mission(self, index: int | None = None) -> None:
        """Begin the mission, at its first item or at another one."""
        self.mode = Mode.AUTO
        self.sequencer.start(self.air(), self.time_s, index)
        self._after_mission()

    def guide(self, target: Target, mode: Mode = Mode.GUIDED) -> None:
        """Fly to a target and loiter there."""
        self.mode = mode
        self.navigator.go_to(target, self.air())

    def return_home(self, target: Target, reason: str) -> None:
        """Fly to home or a rally point, at the return height."""
        if self.mode is not Mode.RTL:
            self.say(reason)
            self.guide(target, Mode.RTL)

    def go_around(self) -> bool:
        """Break a landing off; return whether there is one.

        ArduPlane climbs straight ahead to the height above home that the landing names, and begins
        the approach again. PX4 circles over the landing point, ``MIS_LND_ABRT_ALT`` above it or
        higher.
        """
        if self.mode is not Mode.AUTO or self.sequencer.command != Command.LAND:
            return False
        if self.kind is Kind.ARDUPLANE:
            self.sequencer.climb_away(self.earth.home_m)
            return True
        landing = self.navigator.next
        least_m = landing.z_m + self.parameters["MIS_LND_ABRT_ALT"]
        self.guide(Target(landing.place, max(least_m, self.vehicle.altitude_m)))
        return True

    def home_target(self) -> Target:
        """Return the place to return to without rally points: over home, at the return height.

        A PX4 above the return height keeps its altitude.
        """
        if self.kind is Kind.ARDUPLANE:
            height, radius = self.parameters["RTL_ALTITUDE"], self.parameters["RTL_RADIUS"]
        else:
            height, radius = self.parameters["RTL_RETURN_ALT"], self.parameters["RTL_LOITER_RAD"]
        altitude = self.earth.home_m + height
        if height < 0:
            altitude = self.vehicle.altitude_m
        elif self.kind is Kind.PX4:
            altitude = max(altitude, self.vehicle.altitude_m)
        return Target((0.0, 0.0), altitude, radius_m=abs(radius), clockwise=radius >= 0)

    def tick(self) -> None:
        """Navigate once and fly for :data:`~pathgene.sim.autopilot.vehicle.PERIOD_S` seconds."""
        self.time_s += PERIOD_S
        if self.mode is Mode.LANDED:
            return
        air = self.air()
        step = self._step(air)
        self.height_dem_m = step.height_m
        self.bank_dem_rad = self._bank(step)
        demand = self._vertical(air, step)
        self.vehicle.step(self.bank_dem_rad, demand.pitch_rad, demand.throttle)
        if self.sequencer.has_landed:
            self.mode = Mode.LANDED
            self.say("Landed")

    def _step(self, air: Air) -> Step:
        if self.mode is Mode.AUTO:
            step = self.sequencer.step(air, self.time_s, PERIOD_S)
            self._after_mission()
            if step is not None:
                return step
        steer = self.navigator.steer_loiter(air, PERIOD_S)
        return Step(steer, self.navigator.height_m(air))

    def _after_mission(self) -> None:
        """Return home once the mission says so, or ArduPlane's is complete; PX4 circles there."""
        if self.mode is not Mode.AUTO or not self.sequencer.is_complete:
            return
        if self.sequencer.returns:
            self.return_home(self.return_target(), "Mission returns to home")
        elif self.kind is Kind.ARDUPLANE:
            self.return_home(self.return_target(), "Mission complete, changing mode to RTL")
        else:
            self.say("Mission finished, loitering")
            self.guide(Target(self.vehicle.place, self.vehicle.altitude_m), Mode.IDLE)

    def _bank(self, step: Step) -> float:
        """Return the bank for an acceleration, within the limits of bank and load."""
        get = self.parameters
        pitch = min(max(self.vehicle.pitch_rad, -math.pi / 3), math.pi / 3)
        bank = math.atan(step.steer_m_s2 / (GRAVITY_M_S2 * math.cos(pitch)))
        if self.kind is Kind.PX4:
            limit = math.radians(get["FW_R_LIM"])
            return min(max(bank, -limit), limit)
        limit = math.radians(get["ROLL_LIMIT_DEG"])
        if get["STALL_PREVENTION"]:
            # The square root of the speed over its minimum is the load that the wing carries.
            load = self.vehicle.sensed_eas_m_s / get["AIRSPEED_MIN"]
            if load <= 1:
                limit = min(limit, math.radians(25))
            elif load < self._load(bank):
                limit = min(limit, math.acos(1 / load**2))
        if step.approach is not None and step.approach.flares:
            limit = min(limit, math.radians(get["LEVEL_ROLL_LIMIT"]))
        return min(max(bank, -limit), limit)

    @staticmethod
    def _load(bank_rad: float) -> float:
        """Return the ratio of airspeeds that a bank demands, as ArduPlane computes it."""
        return 1 / math.sqrt(max(math.cos(bank_rad), 0.05))

    def _vertical(self, air: Air, step: Step) -> Demand:
        vehicle = self.vehicle
        if step.pitch_rad is not None:
            self._height.reset()
            return Demand(step.pitch_rad, step.throttle or 0.0)
        now = Vertical(
            vehicle.altitude_m,
            vehicle.velocity[2],
            vehicle.sensed_tas_m_s,
            vehicle.forward_m_s2,
            air.eas2tas,
            vehicle.roll_rad,
            vehicle.pitch_rad,
        )
        load = self._load(self.bank_dem_rad)
        speed = self.cruise_m_s if step.approach is None else step.approach.eas_m_s
        return self._height.update(now, step.height_m, speed, load, PERIOD_S, step.approach)


def loops_of(kind: Kind, parameters: Parameters) -> Loops:
    """Return the attitude loops that the parameters describe."""
    get = parameters
    if kind is Kind.PX4:
        rate = math.radians(get["FW_R_RMAX"])
        return Loops(get["FW_R_TC"], get["FW_P_TC"], rate, math.radians(60))
    return Loops(
        get["RLL2SRV_TCONST"],
        get["PTCH2SRV_TCONST"],
        math.radians(get["RLL2SRV_RMAX"]),
        math.radians(get["PTCH2SRV_RMAX_UP"]),
    )


def start_vehicle(
    kind: Kind,
    parameters: Parameters,
    airframe: Airframe,
    wind: Wind,
    *,
    place: tuple[float, float, float],
    heading_rad: float,
    airspeed_m_s: float,
) -> Vehicle:
    """Return an aircraft in level flight.

    Parameters
    ----------
    place : (float, float, float)
        East and north of home in metres, altitude AMSL.
    heading_rad : float
        Clockwise from north.
    airspeed_m_s : float
        True airspeed.
    """
    return Vehicle(
        airframe,
        loops_of(kind, parameters),
        wind,
        place=place,
        heading_rad=heading_rad,
        airspeed_m_s=airspeed_m_s,
    )
