"""A flight along a smoothed track, step by step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import JobError
from pathgene.host.evaluation.geometry import Piece
from pathgene.host.flight.autopilot import Autopilot
from pathgene.host.flight.guidance import Commands, Guidance, Limits, State
from pathgene.host.flight.models import FlightModel
from pathgene.host.flight.route import Place, Route
from pathgene.host.flight.simulator import STEP_S, Simulator
from pathgene.host.planners.base import Stop
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.limits import GRAVITY_M_S2
from pathgene.host.stages import stage
from pathgene.host.terrain import Terrain


__all__ = [
    "MARGIN",
    "PERIOD_S",
    "Flight",
    "Flown",
    "Sample",
    "flown_of",
    "fly_track",
    "limits_of",
]

# Steps of the model between two updates of the autopilot.
_STEPS = 4
#: Time between two samples of a flight.
PERIOD_S = _STEPS * STEP_S
#: Commands may exceed a limit of the aircraft by this share in order to return to the track.
MARGIN = 0.05

# Steps between two samples of the ground, which only affects the turbulence and the mixture.
_LOOKS = 15
# Duration of the lead-in: the aircraft settles, then the wind rises, then it settles again.
_LEAD_S = 45.0
_WIND_S = (5.0, 20.0)
# Seconds that a change of wind takes.
_TURN_S = 5.0
_SHAKE_S = 25.0
# A flight is lost after this multiple of the expected time, or this far off its track.
_PATIENCE = 2.0
_LOST_M = 3000.0
_LEAD_SLOPE_S = 1.0
_HEIGHT_GAIN = 0.35


@dataclass(frozen=True, eq=False)
class Flown:
    """Samples of a flight every :data:`PERIOD_S`, beginning at the start of the track.

    Parameters
    ----------
    t_s, x, y, z : ndarray
        Seconds since the start was passed, position and altitude: (k,) float64.
    along_m, cross_m, height_error_m : ndarray
        Position relative to the track: horizontal distance along it, distance to the left of it,
        height above it. After the goal, where an autopilot flies the end of its mission, the first
        is the length of the track, and cross_m and height_error_m are NaN.
    airspeed_m_s, bank_rad, climb_m_s, power_W : ndarray
        True airspeed, bank to the right, vertical speed and shaft power, as flown.
    bank_command_rad, climb_command_m_s : ndarray
        Bank and vertical speed as commanded.
    arrived : bool
        The end of the track was reached.
    """

    t_s: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    z: NDArray[np.float64]
    along_m: NDArray[np.float64]
    cross_m: NDArray[np.float64]
    height_error_m: NDArray[np.float64]
    airspeed_m_s: NDArray[np.float64]
    bank_rad: NDArray[np.float64]
    climb_m_s: NDArray[np.float64]
    power_W: NDArray[np.float64]
    bank_command_rad: NDArray[np.float64]
    climb_command_m_s: NDArray[np.float64]
    arrived: bool
    interrupted: bool = False


Sample = tuple[float, ...]
_COLUMNS = tuple(
    field.name for field in fields(Flown) if field.name not in ("arrived", "interrupted")
)


@dataclass(frozen=True)
class _Wind:
    """A steady wind that changes to another one between two times."""

    before: tuple[float, float]
    after: tuple[float, float]
    first_s: float
    last_s: float

    @property
    def changes(self) -> bool:
        return self.before != self.after

    def at(self, time_s: float) -> tuple[float, float]:
        share = min(max((time_s - self.first_s) / (self.last_s - self.first_s), 0.0), 1.0)
        east, north = (
            before + share * (after - before)
            for before, after in zip(self.before, self.after, strict=True)
        )
        return east, north


class Flight:
    """An aircraft in the air that follows a track.

    The flight begins on a straight lead-in before the track, in calm air; there the wind rises, and
    then the turbulence begins. The wind of a flight model must be set after its start: an earlier
    setting is ignored, or the aircraft would begin with the wrong airspeed.

    Parameters
    ----------
    aircraft : Aircraft
        Figures that the path was planned for: airspeed, radius, limits.
    wind : (float, float)
        Velocity of the air, m/s in x and y.
    gusts : str
        Turbulence; see :data:`pathgene.host.flight.simulator.GUSTS`.

    Raises
    ------
    InputError
        As for :class:`Simulator`.
    """

    def __init__(
        self,
        pieces: Sequence[Piece],
        terrain: Terrain,
        aircraft: Aircraft,
        model: FlightModel,
        *,
        wind: tuple[float, float] = (0.0, 0.0),
        gusts: str = "none",
        seed: int = 0,
    ) -> None:
        airspeed = aircraft.cruise_speed_m_s
        self._terrain = terrain
        self._wind = _Wind((0.0, 0.0), wind, *_WIND_S)
        self._shaken = False
        self._looks = 0
        # The wind blows for two thirds of the lead-in.
        route = Route(pieces, _LEAD_S * (airspeed + math.hypot(*wind)))
        x, y, z, east, north = route.start
        _, slope = route.height(-1.0)
        self._simulator = Simulator(
            model,
            middle=(0.5 * terrain.width_m, 0.5 * terrain.height_m),
            place=(x, y, z),
            heading_rad=math.atan2(east, north),
            airspeed_m_s=airspeed,
            slope_rad=math.atan(slope),
            gusts=gusts,
            seed=seed,
        )
        limits = limits_of(aircraft)
        self._autopilot = Autopilot(model, aircraft, PERIOD_S)
        self._guidance = Guidance(
            route,
            limits,
            lookahead_s=model.lookahead_s,
            lead_s=_LEAD_SLOPE_S,
            height_gain=_HEIGHT_GAIN,
            period_s=PERIOD_S,
        )
        self._leg = 0
        self.state: State = self._simulator.state()
        self.commands: Commands = self._guidance.commands(self.state)

    @property
    def route(self) -> Route:
        """The route that is followed."""
        return self._guidance.route

    @property
    def wind(self) -> tuple[float, float]:
        """Velocity of the air over ground, gusts included, m/s in x and y."""
        return self._simulator.wind()

    def follow(self, pieces: Sequence[Piece]) -> None:
        """Continue along another track, which begins next to or astern of the aircraft."""
        self._guidance.follow(Route(pieces))
        self.commands = self._guidance.commands(self.state)

    def turn_wind(self, wind: tuple[float, float]) -> None:
        """Change to another steady wind, given as the velocity of the air, m/s in x and y."""
        now = self.state.time_s
        self._wind = _Wind(self._wind.at(now), wind, now, now + _TURN_S)

    def step(self) -> Sample:
        """Fly on for :data:`PERIOD_S`; return a sample, in the order of :class:`Flown`."""
        stage("flying")
        simulator = self._simulator
        simulator.control(self._autopilot.controls(self.state, self.commands))
        self._weather(self.state.time_s)
        simulator.step(_STEPS)
        state = self.state = simulator.state()
        commands = self.commands = self._guidance.commands(state)
        self._leg = commands.place.leg
        return _sample(
            state, commands.place, commands.height_error_m, commands.bank_rad, commands.climb_m_s
        )

    def step_attitude(self, roll_rad: float, pitch_rad: float, throttle: float) -> Sample:
        """Fly on for :data:`PERIOD_S` with demands of another autopilot; return a sample.

        The climb rate that it commands is unknown, so the one flown takes its place.
        """
        simulator = self._simulator
        simulator.control(self._autopilot.attitude(self.state, roll_rad, pitch_rad, throttle))
        self._weather(self.state.time_s)
        simulator.step(_STEPS)
        state = self.state = simulator.state()
        place = self.route.locate(state.x, state.y, self._leg)
        self._leg = place.leg
        height, _ = self.route.height(place.along_m, place.leg)
        return _sample(state, place, state.z - height, roll_rad, state.climb_m_s)

    def _weather(self, time_s: float) -> None:
        simulator = self._simulator
        if self._looks % _LOOKS == 0:
            simulator.sense_ground(self._terrain.ground(self.state.x, self.state.y))
        self._looks += 1
        wind = self._wind
        if wind.changes and wind.first_s <= time_s <= wind.last_s + PERIOD_S:
            simulator.blow(*wind.at(time_s))
        if time_s >= _SHAKE_S and not self._shaken:
            self._shaken = True
            simulator.shake()


def _sample(
    state: State, place: Place, height_error_m: float, bank_rad: float, climb_m_s: float
) -> Sample:
    """Return a sample in the order of :class:`Flown`; the last two are commands."""
    return (
        state.time_s,
        state.x,
        state.y,
        state.z,
        place.along_m,
        place.cross_m,
        height_error_m,
        state.airspeed_m_s,
        state.roll_rad,
        state.climb_m_s,
        state.power_W,
        bank_rad,
        climb_m_s,
    )


def limits_of(aircraft: Aircraft) -> Limits:
    """Return the largest commands: the aircraft's limits and :data:`MARGIN`.

    The bank follows from its turning radius at its speed.
    """
    speed = aircraft.cruise_speed_m_s
    more = 1 + MARGIN
    return Limits(
        bank_rad=more * math.atan(speed**2 / (GRAVITY_M_S2 * aircraft.turn_radius_m)),
        climb_m_s=more * speed * math.sin(math.radians(aircraft.max_climb_deg)),
        descent_m_s=more * speed * math.sin(math.radians(aircraft.max_descent_deg)),
        # No margin: an engine has no errors to correct.
        power_W=aircraft.engine_power_W or math.inf,
    )


def fly_track(
    flight: Flight, airspeed_m_s: float, slowest_m_s: float, stop: Stop | None = None
) -> Flown:
    """Fly to the end of the track and return the samples since its start.

    Parameters
    ----------
    flight : Flight
        The flight, not begun yet.
    slowest_m_s : float
        Minimum expected ground speed: airspeed minus wind.

    Raises
    ------
    JobError
        If the aircraft is lost before it reaches the start.
    KeyboardInterrupt
        If ``stop`` ends the flight before the start.
    """
    length = flight.route.length_m
    most_s = _PATIENCE * (length / slowest_m_s + 2 * _LEAD_S * airspeed_m_s / slowest_m_s)
    samples: list[Sample] = []
    arrived = False
    stop = Stop() if stop is None else stop
    while not (interrupted := stop.requested):
        sample = flight.step()
        time_s, along, cross = sample[0], sample[4], sample[5]
        if along >= length:
            arrived = True
            break
        if not abs(cross) < _LOST_M or time_s > most_s or not all(map(math.isfinite, sample)):
            break
        if along >= 0:
            samples.append(sample)
    stop.heeded = True
    if interrupted and not samples:
        raise KeyboardInterrupt
    if not samples:
        raise JobError(
            "The aircraft did not reach the start of the path; the gusts are too strong."
        )
    return flown_of(samples, arrived=arrived, interrupted=interrupted)


def flown_of(samples: Sequence[Sample], *, arrived: bool, interrupted: bool) -> Flown:
    """Return the flight of some samples, one or more, whose time counts from the first one."""
    columns = np.array(samples, dtype=np.float64).reshape(-1, len(_COLUMNS)).T.copy()
    columns[0] -= columns[0, 0]
    return Flown(
        **dict(zip(_COLUMNS, columns, strict=True)), arrived=arrived, interrupted=interrupted
    )
