"""Exported missions, uploaded to the simulated autopilot and flown by it.

The entry points of the group ``pathgene.autopilots`` refer to :data:`ARDUPILOT` and :data:`PX4`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from pathgene.host.errors import JobError
from pathgene.host.flight.autopilots import Airborne
from pathgene.host.flight.flight import limits_of
from pathgene.host.formats.flight_plan import WAYPOINT, FlightPlan
from pathgene.host.mission.autopilot.advice import advise
from pathgene.host.mission.autopilot.mavlink_link import Link
from pathgene.host.mission.autopilot.mission_lists import PX4 as PX4_KIND
from pathgene.host.mission.autopilot.upload import upload
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.surface import surface_below
from pathgene.sim.autopilot.airframe import Airframe, eas2tas
from pathgene.sim.autopilot.autopilot import Autopilot, Start
from pathgene.sim.autopilot.connection import Connection
from pathgene.sim.autopilot.controlled import CommandResult
from pathgene.sim.autopilot.flown import Flown
from pathgene.sim.autopilot.items import MISSION, Command, has_place
from pathgene.sim.autopilot.parameters import ARDUPLANE, Parameters
from pathgene.sim.autopilot.parameters import PX4 as PX4_DEFAULTS
from pathgene.sim.autopilot.pilot import Kind, Mode
from pathgene.sim.autopilot.places import Plane, Vector
from pathgene.sim.autopilot.vehicle import PERIOD_S
from pathgene.sim.autopilot.wind import Wind


__all__ = [
    "ARDUPILOT",
    "GUSTS_M_S",
    "PX4",
    "MissionFlyer",
    "UnderWay",
    "airframe_of",
    "fly_items",
    "give_mission",
    "launched",
    "parameters_of",
    "px4_parameters_of",
]

#: Standard deviation of the gusts of a windy flight.
GUSTS_M_S = 1.0
# Seconds of the final circle that are flown.
_CIRCLE_S = 120.0
# A flight is lost that is slower than this over its legs, and after these seconds more.
_SLOWEST_M_S, _MORE_S = 5.0, 600.0
# Distance over which the direction of the frame's north is measured.
_NORTHWARDS_M = 1000.0


def airframe_of(aircraft: Aircraft) -> Airframe:
    """Return the simulated airframe of a planner's aircraft."""
    return Airframe.of(
        weight_n=aircraft.weight_N,
        wing_area_m2=aircraft.wing_area_m2,
        span_m=aircraft.wing_span_m,
        drag_zero=aircraft.zero_lift_drag_coefficient,
        lift_max=aircraft.lift_coefficient_max or 1.4,
        power_w=aircraft.engine_power_W or 30 * aircraft.weight_N,
        cruise_m_s=aircraft.cruise_speed_m_s,
    )


def parameters_of(aircraft: Aircraft) -> Parameters:
    """Return ArduPlane's defaults with the speeds of an aircraft, and its rates up and down.

    The rates are a margin above the aircraft's limits, as :func:`limits_of` returns them.
    """
    most = limits_of(aircraft)
    lift = aircraft.lift_coefficient_max or 1.4
    stall = math.sqrt(2 * aircraft.weight_N / (1.225 * aircraft.wing_area_m2 * lift))
    speed = aircraft.cruise_speed_m_s
    return Parameters(
        ARDUPLANE,
        {
            "AIRSPEED_CRUISE": speed,
            "AIRSPEED_MIN": min(1.2 * stall, 0.9 * speed),
            "AIRSPEED_MAX": 1.4 * speed,
            "TECS_CLMB_MAX": most.climb_m_s,
            "TECS_SINK_MAX": most.descent_m_s,
            "THR_MAX": 100.0,
        },
    )


def px4_parameters_of(aircraft: Aircraft) -> Parameters:
    """Return PX4's defaults with the speeds and rates of :func:`parameters_of`."""
    same = parameters_of(aircraft)
    return Parameters(
        PX4_DEFAULTS,
        {
            "FW_AIRSPD_TRIM": same["AIRSPEED_CRUISE"],
            "FW_AIRSPD_MIN": same["AIRSPEED_MIN"],
            "FW_AIRSPD_MAX": same["AIRSPEED_MAX"],
            "FW_T_CLMB_MAX": same["TECS_CLMB_MAX"],
            "FW_T_CLMB_R_SP": same["TECS_CLMB_MAX"],
            "FW_T_SINK_MAX": same["TECS_SINK_MAX"],
            "FW_T_SINK_R_SP": same["TECS_SINK_MAX"],
        },
    )


def launched(
    problem: Problem,
    plan: FlightPlan,
    seed: int = 0,
    kind: Kind = Kind.ARDUPLANE,
    *,
    gusts_m_s: float | None = None,
) -> Autopilot:
    """Return an autopilot in the air at the first waypoint of a plan, with no mission.

    Its aircraft is the simulated small one, with the figures of the problem's.

    Parameters
    ----------
    seed : int
        Seed of the turbulence.
    gusts_m_s : float, optional
        Standard deviation of the gusts; by default none in calm air, :data:`GUSTS_M_S` in wind.
    """
    first, second, *_ = (item for item in plan.items if item.command == WAYPOINT)
    east = (second.lon - first.lon) * math.cos(math.radians(first.lat))
    heading = math.degrees(math.atan2(east, second.lat - first.lat))
    if gusts_m_s is None:
        gusts_m_s = GUSTS_M_S if any(problem.wind) else 0.0
    parameters = px4_parameters_of if kind is Kind.PX4 else parameters_of
    return Autopilot(
        kind,
        Start(plan.home, (0.0, 0.0), first.alt_m - plan.home[2], heading, armed=False),
        parameters=parameters(problem.aircraft),
        airframe=airframe_of(problem.aircraft),
        wind=Wind(*problem.wind, gusts_m_s=gusts_m_s, seed=seed),
        ground=_ground(problem.terrain),
    )


def give_mission(autopilot: Autopilot, plan: FlightPlan) -> None:
    """Upload a plan over MAVLink, in virtual time.

    Raises
    ------
    JobError
        If the autopilot refuses it.
    """
    connection = Connection(autopilot)
    link = Link(connection, clock=connection.clock)
    link.find(5.0)
    upload(plan, link)


class UnderWay:
    """The mission that an autopilot holds, from its start to a while after its end.

    Attributes
    ----------
    notes : list of str
        A sentence for each parameter that was changed so that the mission starts.
    texts : list of str
        The autopilot's texts for the ground station.

    Raises
    ------
    JobError
        If the autopilot does not start it.
    """

    def __init__(self, autopilot: Autopilot, notes: Sequence[str] = ()) -> None:
        self._autopilot = autopilot
        self._last = len(autopilot.lists.items[MISSION]) - 1
        self._most_s = _MORE_S + _length_m(autopilot) / _SLOWEST_M_S
        self._end_s = math.inf
        self.notes = list(notes)
        self.texts: list[str] = []
        if autopilot.fly_mission() is not CommandResult.ACCEPTED:
            reason = autopilot.mission_refusal() or "the mission is empty"
            raise JobError(f"The autopilot does not start the mission: {reason}")
        autopilot.armed = True

    @property
    def number(self) -> int:
        """Number of the item under way; the last one from the end on."""
        return self._last if self.is_at_end else self._autopilot.pilot.sequencer.index

    @property
    def is_at_end(self) -> bool:
        """True while the last item is under way, and afterwards."""
        pilot = self._autopilot.pilot
        return pilot.mode is not Mode.AUTO or pilot.sequencer.index == self._last

    @property
    def has_arrived(self) -> bool:
        """True once the end has begun to count: on the last circle, or on the ground."""
        return self._end_s < math.inf

    @property
    def is_over(self) -> bool:
        """True once the end has been flown for a while, the aircraft has landed, or is lost."""
        return self._autopilot.pilot.time_s >= min(self._end_s, self._most_s)

    def tick(self) -> None:
        """Fly for a tenth of a second."""
        autopilot = self._autopilot
        pilot = autopilot.pilot
        messages = autopilot.advance(autopilot.time_s + PERIOD_S)
        self.texts += [text for text in map(_text, messages) if text]
        if pilot.mode is Mode.LANDED:
            self._end_s = min(self._end_s, pilot.time_s)
        elif self._end_s == math.inf and self.is_at_end:
            # A landing ends on the ground, a return on its circle.
            lands = pilot.mode is Mode.AUTO and pilot.sequencer.command == Command.LAND
            returns = pilot.mode is Mode.RTL and not pilot.navigator.is_on_circle
            if not (lands or returns):
                self._end_s = pilot.time_s + _CIRCLE_S


def fly_items(autopilot: Autopilot) -> tuple[Flown, bool]:
    """Fly the mission that the autopilot holds, and a while of its end.

    Returns
    -------
    tuple of (Flown, bool)
        The flight; true if it reached the last item.
    """
    pilot = autopilot.pilot
    craft = pilot.vehicle
    mission = UnderWay(autopilot)
    rows = []
    while not mission.is_over:
        mission.tick()
        bank = math.degrees(craft.roll_rad)
        rows.append((pilot.time_s, *craft.place, craft.altitude_m, bank, mission.number))
    table = np.array(rows)
    index = table[:, 5].astype(np.int64)
    flown = Flown(table[:, 0], table[:, 1:3], table[:, 3], table[:, 4], index)
    return flown, mission.has_arrived


class _OnPlane:
    """An aircraft of the host's flight model, on the plane around home.

    The flight model's frame is the terrain's, which is turned against true north.
    """

    def __init__(self, craft: Airborne, terrain: Terrain, plane: Plane) -> None:
        self._craft, self._terrain, self._plane = craft, terrain, plane
        self.forward_m_s2 = 0.0
        self._locate()

    def _locate(self) -> None:
        """Read place and velocities on the plane."""
        state = self._craft.state
        x, y = np.array([state.x, state.x]), np.array([state.y, state.y + _NORTHWARDS_M])
        lat, lon = self._terrain.to_geographic(x, y)
        self.place, north = (
            self._plane.local(*place) for place in zip(lat.tolist(), lon.tolist(), strict=True)
        )
        east, north_ = north[0] - self.place[0], north[1] - self.place[1]
        length = math.hypot(east, north_)
        # The frame's north on the plane.
        self._north = east / length, north_ / length
        self.velocity = (*self._turned(state.east_m_s, state.north_m_s), state.climb_m_s)
        self.wind = self._turned(*self._craft.wind)
        air = self.velocity[0] - self.wind[0], self.velocity[1] - self.wind[1]
        level = max(math.hypot(*air), 1e-6)
        self.nose = air[0] / level, air[1] / level

    def _turned(self, x: float, y: float) -> Vector:
        east, north = self._north
        return x * north + y * east, y * north - x * east

    @property
    def altitude_m(self) -> float:
        """Altitude AMSL."""
        return self._craft.state.z

    @property
    def roll_rad(self) -> float:
        """Bank, positive to the right."""
        return self._craft.state.roll_rad

    @property
    def pitch_rad(self) -> float:
        """Pitch, positive up."""
        return self._craft.state.pitch_rad

    @property
    def throttle(self) -> float:
        """Throttle from 0 to 1."""
        return self._craft.throttle

    @property
    def eas2tas(self) -> float:
        """True airspeed divided by equivalent airspeed at this altitude."""
        return eas2tas(self.altitude_m)

    @property
    def sensed_eas_m_s(self) -> float:
        """Equivalent airspeed, without an error of the sensor."""
        return self.sensed_tas_m_s / self.eas2tas

    @property
    def sensed_tas_m_s(self) -> float:
        """True airspeed."""
        return self._craft.state.airspeed_m_s

    def step(self, roll_rad: float, pitch_rad: float, throttle: float) -> None:
        """Fly for a tenth of a second with these demands."""
        before = self.velocity
        self._craft.step(roll_rad, pitch_rad, throttle)
        self._locate()
        ax, ay, az = (
            (new - old) / PERIOD_S for new, old in zip(self.velocity, before, strict=True)
        )
        (east, north), pitch = self.nose, self.pitch_rad
        self.forward_m_s2 = math.cos(pitch) * (ax * east + ay * north) + math.sin(pitch) * az


@dataclass(frozen=True)
class MissionFlyer:
    """A simulated autopilot that flies an exported mission with an aircraft of the host.

    Parameters
    ----------
    title : str
        Its name in reports.
    """

    kind: Kind
    title: str

    def accept(
        self, problem: Problem, plan: FlightPlan, aircraft: Aircraft, craft: Airborne
    ) -> UnderWay:
        """Upload a plan and begin its mission.

        Raises
        ------
        JobError
            If the autopilot refuses the plan.
        """
        is_px4 = self.kind is Kind.PX4
        parameters = px4_parameters_of(aircraft) if is_px4 else parameters_of(aircraft)
        parameters.update(_measured(self.kind, aircraft, craft))
        terrain = problem.terrain
        autopilot = Autopilot(
            self.kind,
            Start(plan.home, armed=False),
            parameters=parameters,
            ground=_ground(terrain),
            craft=lambda plane: _OnPlane(craft, terrain, plane),
        )
        give_mission(autopilot, plan)
        notes = _follow_advice(parameters, plan) if is_px4 else []
        if is_px4 and not any(item.command == Command.LAND for item in plan.items):
            reason = autopilot.mission_refusal()
            if reason is not None:
                parameters["MIS_TKO_LAND_REQ"] = 0.0
                notes.append(
                    "PX4 with its default MIS_TKO_LAND_REQ 2 does not start this mission "
                    f"({reason.removeprefix('Mission rejected: ').rstrip('.')}); it is flown with "
                    "MIS_TKO_LAND_REQ 0."
                )
        return UnderWay(autopilot, notes)


def _measured(kind: Kind, aircraft: Aircraft, craft: Airborne) -> dict[str, float]:
    """Return the parameters that a user measures, by the autopilots' manuals.

    They are the throttle in level flight, the sink without throttle, and the climb at full
    throttle, from which both autopilots scale the throttle. In gusts, ArduPlane holds less than
    its maximum climb, so the maximum is not the steepest climb of plans.
    """
    is_px4 = kind is Kind.PX4
    names = ("FW_THR_TRIM", "FW_T_SINK_MIN", "FW_T_CLMB_MAX")
    trim, sink, climb = names if is_px4 else ("TRIM_THROTTLE", "TECS_SINK_MIN", "TECS_CLMB_MAX")
    level, more = craft.level_throttle, craft.climb_throttle
    speed = aircraft.cruise_speed_m_s
    return {
        trim: 100 * level,
        sink: speed * level / more,
        climb: max(speed * (1 - level) / more, limits_of(aircraft).climb_m_s),
    }


def _follow_advice(parameters: Parameters, plan: FlightPlan) -> list[str]:
    """Set the tolerance of PX4's heights at waypoints as an upload advises, and say so."""
    names = ("NAV_FW_ALT_RAD", "FW_T_ALT_TC")
    values = advise(plan, {name: parameters[name] for name in names}, PX4_KIND, None).values
    parameters.update(values)
    return [
        f"{name} is {value:g}, as pathgene upload --set-parameters sets it for this mission."
        for name, value in values.items()
    ]


def _ground(terrain: Terrain) -> Callable[[float, float], float]:
    """Return the altitude of a terrain's surface by latitude and longitude."""

    def ground(lat: float, lon: float) -> float:
        x, y = terrain.to_local(np.array([lat]), np.array([lon]))
        return float(surface_below(terrain, x, y, void_m=math.nan)[0])

    return ground


def _length_m(autopilot: Autopilot) -> float:
    """Return the length of the legs of the mission that an autopilot holds."""
    plane = autopilot.earth.plane
    items = [item for item in autopilot.lists.items[MISSION] if item.navigates and has_place(item)]
    places = [plane.local(item.lat, item.lon) for item in items]
    return sum(math.dist(*leg) for leg in pairwise(places))


def _text(message: Any) -> str:
    """Return the text of a message that carries one."""
    return str(message.text) if message.get_type() == "STATUSTEXT" else ""


#: The entry points ``ardupilot`` and ``px4`` refer to these objects.
ARDUPILOT = MissionFlyer(Kind.ARDUPLANE, "ArduPlane")
PX4 = MissionFlyer(Kind.PX4, "PX4")
