"""Navigation of ArduPlane: the leg under way, loiters, and the height to ask for."""

from __future__ import annotations

import math

from pathgene.sim.autopilot.items import Frame
from pathgene.sim.autopilot.lateral import L1
from pathgene.sim.autopilot.parameters import Parameters
from pathgene.sim.autopilot.places import Vector, distance, past, share
from pathgene.sim.autopilot.plane_landing import PlaneLanding
from pathgene.sim.autopilot.targets import Air, Step, Target


__all__ = ["PlaneNavigator"]

# A mission climbs at its slope above this height over home, and as fast as it can below.
_SLOPES_ABOVE_M = 20.0
# A loiter that lies farther away than this multiple of its radius is approached along the leg.
_APPROACH_RADII = 3.0
# A landing is steered towards a point this far ahead on its line, so that it never turns back.
_AHEAD_M = 200.0


class PlaneNavigator:
    """The leg between the previous and the next target.

    A target that the aircraft has already passed when it becomes the next one is flown back to: the
    leg then begins at the aircraft. That is a full circle at the bank limit.

    Attributes
    ----------
    previous, next : Target
        Ends of the leg.
    has_circled : bool
        Whether the loiter at the next target has been reached.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.law = L1(
            parameters["NAVL1_PERIOD"], parameters["NAVL1_DAMPING"], parameters["NAVL1_XTRACK_I"]
        )
        self.previous = self.next = Target((0.0, 0.0), 0.0)
        self.has_circled = False
        self._follows_leg = False
        self._next_follows_leg = False
        self._slope_m = 0.0
        self._turn_rad = math.pi / 2
        self._landing: PlaneLanding | None = None

    def enter(self, air: Air) -> None:
        """Begin a mission here: the way to its first waypoint is no leg to keep to."""
        self.previous = self.next = Target(air.place, air.altitude_m)
        self._next_follows_leg = False

    def set_next(self, target: Target, air: Air, after: Vector | None) -> None:
        """Make a target of a mission the next one.

        Parameters
        ----------
        after : (float, float) or None
            Place of the target after it; the turn there decides when this one is reached.
        """
        here = Target(air.place, air.altitude_m)
        self._follows_leg = self._next_follows_leg
        self.previous = self.next if self._follows_leg else here
        self._next_follows_leg = True
        self.next = target
        if past(air.place, self.previous.place, target.place):
            self.previous = here
        self.has_circled = False
        above_home = air.altitude_m - air.earth.home_m
        goes_down = air.altitude_m > target.altitude_m(air.earth, air.place)
        is_sloped = above_home > _SLOPES_ABOVE_M or goes_down
        self._slope_m = self._slope(self.previous, air) if is_sloped else 0.0
        self._turn_rad = self._turn(after)
        self._landing = None
        if target.lands:
            self._landing = PlaneLanding(self._parameters, self.previous, target)

    def go_to(self, target: Target, air: Air) -> None:
        """Fly straight to a target and loiter there, as in RTL and guided flight."""
        here = Target(air.place, air.altitude_m)
        self.previous, self.next = here, target
        self._follows_leg = self._next_follows_leg = False
        self.has_circled = False
        goes_down = air.altitude_m > target.altitude_m(air.earth, air.place)
        self._slope_m = self._slope(here, air) if goes_down else 0.0

    def break_leg(self) -> None:
        """Forget the leg, as after take-off: the next target is flown to from where it is set."""
        self._next_follows_leg = False

    def steer_leg(self, air: Air, dt_s: float) -> float:
        """Return the acceleration to the right along the leg, m/s^2."""
        start = self.previous.place if self._follows_leg else air.place
        return self.law.leg(air.motion, start, self.next.place, dt_s)

    def steer_loiter(self, air: Air, dt_s: float) -> float:
        """Return the acceleration to the right that leads to the loiter and around it, m/s^2.

        The circle has the radius that is asked for times the squared ratio of airspeeds, so that
        the bank stays the one of sea level.
        """
        radius = self._radius(self.next)
        far = distance(air.place, self.next.place) > _APPROACH_RADII * radius
        if not self.has_circled and self._follows_leg and far:
            return self.steer_leg(air, dt_s)
        steer = self.law.circle(
            air.motion,
            self.next.place,
            radius * air.eas2tas**2,
            clockwise=self.next.clockwise,
        )
        beyond = share(air.place, self.previous.place, self.next.place) > 1
        self.has_circled |= self.law.is_on_circle or beyond
        return steer

    def arrival(self, air: Air, acceptance_m: float) -> str | None:
        """Return ``Reached`` or ``Passed`` if the next waypoint is done, else None.

        Parameters
        ----------
        acceptance_m : float
            The item's acceptance radius; 0 leaves it to the turn that follows.
        """
        if not acceptance_m:
            wide = min(self._parameters["WP_RADIUS"] * air.eas2tas**2, self.law.distance_m)
            acceptance_m = wide * min(abs(self._turn_rad) / (math.pi / 2), 1.0)
        if distance(air.place, self.next.place) <= acceptance_m:
            return "Reached"
        if past(air.place, self.previous.place, self.next.place):
            return "Passed"
        return None

    def height_m(self, air: Air) -> float:
        """Return the altitude AMSL to ask for now."""
        stop = self.next.altitude_m(air.earth, air.place)
        is_there = self.law.is_on_circle or past(air.place, self.previous.place, self.next.place)
        if is_there or not self._slope_m:
            return stop
        flown = share(air.place, self.previous.place, self.next.place)
        left = 1.0 - min(max(flown, 0.0), 1.0)
        asked = stop - self._slope_m * left
        threshold = self._parameters["ALT_SLOPE_MAXHGT"]
        if threshold > 0 and self._slope_m > 0 and air.altitude_m - asked > threshold:
            # The aircraft is above its slope of climb: the slope begins again where it is.
            rest = self._above_minimum(stop - air.altitude_m)
            asked = stop - rest * left
            self._slope_m = rest / left if left > 0 else rest
        start = self.previous.altitude_m(air.earth, air.place)
        return min(max(asked, min(start, stop)), max(start, stop))

    def land(self, air: Air, dt_s: float) -> tuple[Step, bool]:
        """Return the demands of a landing, and whether the aircraft flares."""
        landing, start, stop = self._landing, self.previous.place, self.next.place
        assert landing is not None
        length = distance(start, stop)
        ahead = (distance(start, air.place) + _AHEAD_M) / max(length, 1e-3)
        beyond = start[0] + ahead * (stop[0] - start[0]), start[1] + ahead * (stop[1] - start[1])
        steer = self.law.leg(air.motion, start, beyond, dt_s)
        height, approach = landing.update(air, self.law.crosstrack_m, self.height_m(air))
        return Step(steer, height, approach=approach), approach.flares

    @property
    def is_on_circle(self) -> bool:
        """True while the aircraft flies the circle of a loiter."""
        return self.law.is_on_circle

    def _slope(self, start: Target, air: Air) -> float:
        """Return the height that a leg changes, 0 if it is flown as a step."""
        stop_m = self.next.altitude_m(air.earth, air.place)
        if self.next.frame == Frame.TERRAIN:
            return self._above_minimum(stop_m - air.altitude_m)
        return self._above_minimum(stop_m - start.altitude_m(air.earth, air.place))

    def _above_minimum(self, height_m: float) -> float:
        least = 1e-3 if self.next.lands else self._parameters["ALT_SLOPE_MIN"]
        return 0.0 if least <= 0 or abs(height_m) < least else height_m

    def _radius(self, target: Target) -> float:
        # A radius of 1 or less, too, means the parameter.
        return target.radius_m if target.radius_m > 1 else abs(self._parameters["WP_LOITER_RAD"])

    def _turn(self, after: Vector | None) -> float:
        """Return the turn at the next target, radians."""
        if after is None:
            return math.pi / 2
        (x0, y0), (x1, y1), (x2, y2) = self.previous.place, self.next.place, after
        turn = math.atan2(x2 - x1, y2 - y1) - math.atan2(x1 - x0, y1 - y0)
        return math.remainder(turn, 2 * math.pi)
