"""JSBSim in the terrain's local frame: state out, controls in.

The flight takes place at the equator, with the centre of the terrain at latitude and longitude 0
and the frame's axes along the parallel and the meridian. There the grid has no convergence, so the
model's north is the frame's north, and 40 km from the centre a metre of the frame equals a metre of
the model to 2 parts in 100,000. Altitudes are relative to the terrain's datum.
"""

from __future__ import annotations

import math
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.flight.guidance import State
from pathgene.host.flight.models import FlightModel


__all__ = ["GUSTS", "STEP_S", "Controls", "Simulator"]

#: Step of the model.
STEP_S = 1 / 120

#: Dryden turbulence by its name: wind at 20 feet in feet per second, and JSBSim's number of the
#: probability of exceedance above 2000 feet. Source: MIL-F-8785C, light, moderate and severe.
GUSTS = {"none": None, "light": (25.0, 3), "moderate": (50.0, 4), "severe": (75.0, 6)}

_FOOT_M = 0.3048
_HORSEPOWER_W = 745.69987
_MOST_SEED = 2**31 - 1
# Radii of WGS84 at the equator: along the parallel and along the meridian.
_EAST_M = 6378137.0
_NORTH_M = 6335439.327
# Minimum distance to the ground that the model is told: closer, its wheels would bounce off the
# ground.
_WHEELS_M = 60.0

Controls = tuple[float, float, float, float, float]


class Simulator:
    """A flight model in the air.

    Parameters
    ----------
    middle : (float, float)
        x and y of the terrain's centre, metres.
    place : (float, float, float)
        x, y and altitude at the start.
    heading_rad : float
        Heading at the start, clockwise from the frame's north.
    airspeed_m_s : float
        True airspeed at the start.
    slope_rad : float
        Angle of the flight path at the start.
    gusts : str
        Turbulence, a name of :data:`GUSTS`.
    seed : int
        Seed of the turbulence, 0 to 2^31 - 2.

    Raises
    ------
    InputError
        If the package ``jsbsim`` is missing, or ``gusts`` or ``seed`` are bad.
    """

    def __init__(
        self,
        model: FlightModel,
        *,
        middle: tuple[float, float],
        place: tuple[float, float, float],
        heading_rad: float,
        airspeed_m_s: float,
        slope_rad: float = 0.0,
        gusts: str = "none",
        seed: int = 0,
    ) -> None:
        if gusts not in GUSTS:
            raise InputError(f"Gusts must be one of {', '.join(GUSTS)}, not {gusts!r}.")
        if not 0 <= seed < _MOST_SEED:
            raise InputError(f"The seed of a flight must be 0 to {_MOST_SEED - 1}, not {seed}.")
        self.model = model
        self._middle = middle
        self._gusts = GUSTS[gusts]
        self._seed = seed + 1  # JSBSim treats 0 as 1.
        self._start_s = 0.0
        self._executive = _loaded(model)
        self._start(place, heading_rad, airspeed_m_s, slope_rad)

    def step(self, steps: int = 1) -> None:
        """Fly a number of steps of :data:`STEP_S` with the current controls."""
        run = self._executive.run
        for _ in range(steps):
            run()

    def state(self) -> State:
        """Return the current state."""
        get = self._executive.get_property_value
        return State(
            time_s=get("simulation/sim-time-sec") - self._start_s,
            x=self._middle[0] + get("position/long-gc-rad") * _EAST_M,
            y=self._middle[1] + get("position/lat-geod-rad") * _NORTH_M,
            z=get("position/h-sl-meters"),
            east_m_s=get("velocities/v-east-fps") * _FOOT_M,
            north_m_s=get("velocities/v-north-fps") * _FOOT_M,
            climb_m_s=get("velocities/h-dot-fps") * _FOOT_M,
            airspeed_m_s=get("velocities/vt-fps") * _FOOT_M,
            roll_rad=get("attitude/phi-rad"),
            pitch_rad=get("attitude/theta-rad"),
            p_rad_s=get("velocities/p-rad_sec"),
            q_rad_s=get("velocities/q-rad_sec"),
            sideslip_rad=get("aero/beta-rad"),
            power_W=get("propulsion/engine/power-hp") * _HORSEPOWER_W,
        )

    def control(self, controls: Controls) -> None:
        """Set aileron, elevator, rudder (-1 to 1), throttle and air brake (0 to 1).

        A positive aileron rolls to the right, a positive elevator pitches up, a positive rudder
        yaws to the right.
        """
        put = self._executive.set_property_value
        aileron, elevator, rudder, throttle, brake = controls
        put("fcs/aileron-cmd-norm", aileron)
        put("fcs/elevator-cmd-norm", -elevator)
        put("fcs/rudder-cmd-norm", -rudder)
        put("fcs/throttle-cmd-norm", throttle)
        put("fcs/speedbrake-cmd-norm", brake)

    def blow(self, east_m_s: float, north_m_s: float) -> None:
        """Set the steady wind, given as the velocity of the air."""
        self._executive["atmosphere/wind-east-fps"] = east_m_s / _FOOT_M
        self._executive["atmosphere/wind-north-fps"] = north_m_s / _FOOT_M

    def wind(self) -> tuple[float, float]:
        """Return the velocity of the air, gusts included, m/s in x and y."""
        get = self._executive.get_property_value
        return (
            get("atmosphere/total-wind-east-fps") * _FOOT_M,
            get("atmosphere/total-wind-north-fps") * _FOOT_M,
        )

    def sense_ground(self, ground_m: float) -> None:
        """Tell the model the altitude of the ground below, for the turbulence and the mixture."""
        z = float(self._executive["position/h-sl-meters"])
        ground_m = min(ground_m, z - _WHEELS_M) if math.isfinite(ground_m) else z - _WHEELS_M
        self._executive["position/terrain-elevation-asl-ft"] = ground_m / _FOOT_M
        if self.model.lean_per_km:
            mixture = 1.0 - self.model.lean_per_km * max(z, 0.0) / 1000
            self._executive["fcs/mixture-cmd-norm"] = max(mixture, 0.5)

    def shake(self) -> None:
        """Begin the turbulence."""
        if self._gusts is None:
            return
        wind_ft_s, severity = self._gusts
        self._executive["simulation/randomseed"] = self._seed
        self._executive["atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps"] = wind_ft_s
        self._executive["atmosphere/turbulence/milspec/severity"] = severity
        self._executive["atmosphere/turb-type"] = 3

    def _start(
        self,
        place: tuple[float, float, float],
        heading_rad: float,
        airspeed_m_s: float,
        slope_rad: float,
    ) -> None:
        executive = self._executive
        x, y, z = place
        executive["ic/lat-geod-rad"] = (y - self._middle[1]) / _NORTH_M
        executive["ic/long-gc-rad"] = (x - self._middle[0]) / _EAST_M
        executive["ic/terrain-elevation-ft"] = (z - 1000.0) / _FOOT_M
        executive["ic/h-sl-ft"] = z / _FOOT_M
        executive["ic/vt-fps"] = airspeed_m_s / _FOOT_M
        executive["ic/psi-true-rad"] = heading_rad
        executive["ic/gamma-rad"] = slope_rad
        executive["ic/alpha-rad"] = math.radians(2.0)
        executive.run_ic()
        executive["propulsion/set-running"] = -1
        executive["simulation/randomseed"] = self._seed
        self._start_s = float(executive["simulation/sim-time-sec"])
        self.sense_ground(-math.inf)


def _loaded(model: FlightModel) -> Any:
    """Return JSBSim with the model's files read."""
    package = _package()
    # Its greeting goes to standard output, which is for results.
    package.FGJSBBase().debug_lvl = 0
    executive: Any = package.FGFDMExec(None)
    executive.set_debug_level(0)
    executive.set_dt(STEP_S)
    if model.folder is not None:
        executive.set_aircraft_path(str(model.folder))
    if not executive.load_model(model.jsbsim):
        raise InputError(f"JSBSim cannot read its model {model.jsbsim!r}.")
    return executive


def _package() -> Any:
    try:
        import jsbsim
    except ImportError:
        raise InputError(
            "Flying needs the extra pathgene[fly]: pip install 'pathgene[fly]', or pip install "
            "jsbsim."
        ) from None
    return jsbsim
