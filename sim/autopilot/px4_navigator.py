"""Navigation of PX4: legs and loiters by NPFG, waypoints that are reached and never passed."""

from __future__ import annotations

import math

from pathgene.sim.autopilot.npfg import Npfg
from pathgene.sim.autopilot.parameters import Parameters
from pathgene.sim.autopilot.places import Vector, cross, distance, dot, past, share
from pathgene.sim.autopilot.targets import Air, Step, Target


__all__ = ["Px4Navigator"]

# Below this height over the landing point, wings stay level and the demanded height is as far below
# it, so that the aircraft touches down.
_TOUCHDOWN_M = 3.0


class Px4Navigator:
    """The leg between the previous and the next target.

    A waypoint counts once the aircraft is within its acceptance radius, or the distance at which
    the law would turn anyway, and within ``NAV_FW_ALT_RAD`` of its altitude. A waypoint that was
    passed outside that is flown back to.

    Attributes
    ----------
    previous, next : Target
        Ends of the leg.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.law = Npfg(
            parameters["NPFG_PERIOD"], parameters["NPFG_DAMPING"], parameters["NPFG_ROLL_TC"]
        )
        self.previous = self.next = Target((0.0, 0.0), 0.0)
        self._follows_leg = False
        self._is_near = False

    def enter(self, air: Air) -> None:
        """Begin a mission here."""
        self.previous = self.next = Target(air.place, air.altitude_m)
        self._follows_leg = False

    def set_next(self, target: Target, air: Air, after: Vector | None) -> None:
        """Make a target of a mission the next one; PX4 does not look at the one after it."""
        self.previous = self.next if self._follows_leg else Target(air.place, air.altitude_m)
        self._follows_leg = True
        self.next = target
        self._is_near = False

    def go_to(self, target: Target, air: Air) -> None:
        """Fly straight to a target and loiter there."""
        self.previous, self.next = Target(air.place, air.altitude_m), target
        self._follows_leg = False
        self._is_near = False

    def break_leg(self) -> None:
        """Forget the leg."""
        self._follows_leg = False

    def steer_leg(self, air: Air, dt_s: float) -> float:
        """Return the acceleration to the right along the leg, m/s^2."""
        self._is_near = False
        start, stop, place = self.previous.place, self.next.place, air.place
        length = distance(start, stop)
        # A landing keeps to its line beyond its point.
        is_over = past(place, start, stop) and not self.next.lands
        if length < 1e-3 or is_over:
            return self._straight_to(stop, air)
        tangent = ((stop[0] - start[0]) / length, (stop[1] - start[1]) / length)
        offset = (place[0] - start[0], place[1] - start[1])
        if dot(offset, tangent) < -abs(cross(tangent, offset)):
            return self._straight_to(start, air)
        return self.law.steer(air.motion.velocity, air.wind, tangent, cross(tangent, offset), 0.0)

    def steer_loiter(self, air: Air, dt_s: float) -> float:
        """Return the acceleration to the right that leads to the loiter and around it, m/s^2."""
        radius = self._radius()
        centre, place = self.next.place, air.place
        away = distance(centre, place)
        if self._follows_leg and away > 3 * radius:
            return self.steer_leg(air, dt_s)
        sense = 1.0 if self.next.clockwise else -1.0
        self._is_near |= away < 1.2 * radius
        if away < 0.1:
            outwards = air.motion.nose
        else:
            outwards = ((place[0] - centre[0]) / away, (place[1] - centre[1]) / away)
        tangent = (sense * outwards[1], -sense * outwards[0])
        # Left of a clockwise circle is outside.
        error = -sense * (away - radius)
        return self.law.steer(air.motion.velocity, air.wind, tangent, error, sense / radius)

    def arrival(self, air: Air, acceptance_m: float) -> str | None:
        """Return ``Reached`` if the next waypoint is done, else None."""
        get = self._parameters
        switch_m = self.law.error_bound_m * get["NPFG_SW_DST_MLT"]
        acceptance = max(acceptance_m or get["NAV_ACC_RAD"], switch_m)
        gap = abs(air.altitude_m - self.next.altitude_m(air.earth, air.place))
        is_there = distance(air.place, self.next.place) <= acceptance
        return "Reached" if is_there and gap <= get["NAV_FW_ALT_RAD"] else None

    def height_m(self, air: Air) -> float:
        """Return the altitude AMSL to ask for: a straight line between the ends of the leg."""
        stop = self.next.altitude_m(air.earth, air.place)
        if not self._follows_leg or self._is_near:
            return stop
        start = self.previous.altitude_m(air.earth, air.place)
        flown = share(air.place, self.previous.place, self.next.place)
        return start + (stop - start) * min(max(flown, 0.0), 1.0)

    def land(self, air: Air, dt_s: float) -> tuple[Step, bool]:
        """Return the demands of a landing, and whether the aircraft is about to touch down."""
        ground = self.next.altitude_m(air.earth, air.place)
        if air.altitude_m - ground > _TOUCHDOWN_M:
            return Step(self.steer_leg(air, dt_s), self.height_m(air)), False
        return Step(0.0, ground - _TOUCHDOWN_M), True

    @property
    def is_on_circle(self) -> bool:
        """True while the aircraft flies the circle of a loiter."""
        return self._is_near

    def _straight_to(self, place: Vector, air: Air) -> float:
        (x, y), (to_x, to_y) = air.place, place
        away = math.hypot(to_x - x, to_y - y)
        if away < 1e-3:
            return 0.0
        tangent = ((to_x - x) / away, (to_y - y) / away)
        return self.law.steer(air.motion.velocity, air.wind, tangent, 0.0, 0.0)

    def _radius(self) -> float:
        return self.next.radius_m or abs(self._parameters["NAV_LOITER_RAD"])
