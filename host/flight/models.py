"""The flight models: our own aircraft, and two that come with JSBSim."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pathgene.host.errors import InputError
from pathgene.host.problem import aircraft
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.suggestion import did_you_mean


__all__ = ["MODELS", "FlightModel", "model_for", "model_named"]

_OURS = Path(__file__).with_name("aircraft")


@dataclass(frozen=True, kw_only=True)
class FlightModel:
    """An aircraft that JSBSim flies, and the gains of its autopilot.

    Gains hold at the cruise speed and grow with the inverse square of the airspeed.

    Parameters
    ----------
    name : str
        Name of the planning figures of the same aircraft, as ``--uav`` takes them.
    folder : Path, optional
        Folder of models that contains it; by default the folder of the package ``jsbsim``.
    lookahead_s : float
        Length of the guidance's L1 in seconds.
    pitch_gain, pitch_trim_gain : float
        Elevator per error of the pitch rate, s/rad, and per its integral, 1/rad.
    throttle_level, throttle_climb : float
        Throttle of level flight, and its increase in a climb per unit of the sine.
    rudder_gain : float
        Rudder per radian of sideslip.
    brake_level, brake_climb : float
        Sine of the descent angle beyond which the air brake is used, and brake per unit of the
        sine; 0 without an air brake.
    lean_per_km : float
        Share of the mixture taken away per kilometre of altitude; 0 for an engine without a
        mixture.
    slowest : float
        Share of the planned airspeed below which height is traded for speed: the share at which
        full power no longer holds the climb. Near the stall, height is always traded for speed.
    speed_gain, speed_trim_gain : float
        Throttle per missing share of airspeed, and per integral of that share, 1/s.
    """

    name: str
    jsbsim: str
    folder: Path | None = None
    lookahead_s: float
    roll_rate_rad_s: float
    pitch_gain: float
    pitch_trim_gain: float
    throttle_level: float
    throttle_climb: float
    rudder_gain: float = 0.0
    brake_level: float = 0.0
    brake_climb: float = 0.0
    lean_per_km: float = 0.0
    slowest: float = 0.0
    speed_gain: float = 4.0
    speed_trim_gain: float = 0.6

    def figures(self) -> Aircraft:
        """Return the planning figures of the aircraft."""
        return aircraft.load(self.name)


MODELS = {
    model.name: model
    for model in (
        FlightModel(
            name="silver-fox",
            jsbsim="silver-fox",
            folder=_OURS,
            lookahead_s=3.3,
            roll_rate_rad_s=2.2,
            pitch_gain=0.35,
            pitch_trim_gain=0.8,
            throttle_level=0.14,
            throttle_climb=2.1,
            brake_level=0.07,
            brake_climb=2.1,
        ),
        FlightModel(
            name="c172p",
            jsbsim="c172p",
            lookahead_s=4.0,
            roll_rate_rad_s=1.0,
            pitch_gain=1.2,
            pitch_trim_gain=1.5,
            throttle_level=0.66,
            throttle_climb=3.0,
            rudder_gain=1.0,
            lean_per_km=0.08,
            slowest=0.8,
            speed_gain=8.0,
            speed_trim_gain=0.1,
        ),
        FlightModel(
            name="j3cub",
            jsbsim="J3Cub",
            lookahead_s=3.5,
            roll_rate_rad_s=1.0,
            pitch_gain=1.0,
            pitch_trim_gain=1.5,
            throttle_level=0.57,
            throttle_climb=3.5,
            rudder_gain=1.0,
            lean_per_km=0.08,
        ),
    )
}


def model_named(name: str) -> FlightModel:
    """Return a flight model by its name.

    Raises
    ------
    InputError
        If there is no such model.
    """
    if name not in MODELS:
        raise InputError(
            f"There is no flight model {name!r}{did_you_mean(name, MODELS)}; choose from "
            f"{', '.join(MODELS)} (--aircraft)."
        )
    return MODELS[name]


def model_for(planned: Aircraft) -> FlightModel:
    """Return the flight model of the aircraft that a path was planned for.

    Raises
    ------
    InputError
        If the aircraft has none.
    """
    for model in MODELS.values():
        if model.figures().name == planned.name:
            return model
    raise InputError(
        f"There is no flight model of {planned.name}; choose one of {', '.join(MODELS)} "
        "with --aircraft."
    )
