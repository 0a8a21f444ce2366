"""Messages that the autopilot sends by itself: heartbeat, position, state of the mission."""

from __future__ import annotations

import math
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from pathgene.sim.autopilot.commands import custom_mode
from pathgene.sim.autopilot.controlled import Controlled
from pathgene.sim.autopilot.items import DEGREES, MISSION
from pathgene.sim.autopilot.pilot import Mode


__all__ = ["Telemetry"]

# Values of MAV_TYPE, MAV_MODE_FLAG and MAV_STATE.
_FIXED_WING = 1
_CUSTOM, _ARMED = 1, 128
_STANDBY, _ACTIVE = 3, 4
# Values of MISSION_STATE.
_NO_MISSION, _NOT_STARTED, _RUNS, _PAUSED, _COMPLETE = 1, 2, 3, 4, 5
_POSITION_S, _STATE_S = 0.25, 1.0


class Telemetry:
    """Sender of messages that are due.

    Parameters
    ----------
    autopilot : Controlled
        The autopilot whose state is sent.
    """

    def __init__(self, autopilot: Controlled) -> None:
        self._autopilot = autopilot
        self._position_s = self._state_s = 0.0

    def due(self, now_s: float) -> list[Any]:
        """Return the messages that are due: positions four times a second, the rest once."""
        out = []
        if now_s >= self._position_s:
            self._position_s = now_s + _POSITION_S
            up_s = now_s - self._autopilot.booted_s
            out += [self._position(up_s), self._attitude(up_s)]
        if now_s >= self._state_s:
            self._state_s = now_s + _STATE_S
            out += [self.heartbeat(), self.mission_current(), self._speeds()]
        return out

    def heartbeat(self) -> Any:
        """Return the heartbeat."""
        autopilot = self._autopilot
        return mavlink.MAVLink_heartbeat_message(
            _FIXED_WING,
            autopilot.kind.value,
            _CUSTOM | (_ARMED if autopilot.armed else 0),
            custom_mode(autopilot.pilot.mode, autopilot.kind),
            _ACTIVE if autopilot.armed else _STANDBY,
            3,
        )

    def mission_current(self) -> Any:
        """Return the item under way and the state of the mission."""
        autopilot = self._autopilot
        sequencer = autopilot.pilot.sequencer
        total = len(autopilot.lists.items[MISSION])
        # PX4 reports a mission that it will not start as none.
        if total <= sequencer.first or autopilot.mission_refusal() is not None:
            state = _NO_MISSION
        elif autopilot.pilot.mode is Mode.AUTO:
            state = _RUNS
        elif sequencer.is_complete:
            state = _COMPLETE
        else:
            state = _PAUSED if sequencer.is_running else _NOT_STARTED
        return mavlink.MAVLink_mission_current_message(
            sequencer.index, total=total, mission_state=state
        )

    def _position(self, now_s: float) -> Any:
        autopilot = self._autopilot
        vehicle = autopilot.pilot.vehicle
        lat, lon = autopilot.earth.plane.degrees(vehicle.place)
        east, north, up = vehicle.velocity
        heading = math.degrees(math.atan2(*vehicle.nose)) % 360
        return mavlink.MAVLink_global_position_int_message(
            _milliseconds(now_s),
            round(lat * DEGREES),
            round(lon * DEGREES),
            round(vehicle.altitude_m * 1000),
            round((vehicle.altitude_m - autopilot.earth.home_m) * 1000),
            round(north * 100),
            round(east * 100),
            round(-up * 100),
            round(heading * 100) % 36000,
        )

    def _attitude(self, now_s: float) -> Any:
        vehicle = self._autopilot.pilot.vehicle
        heading = math.atan2(*vehicle.nose)
        angles = (vehicle.roll_rad, vehicle.pitch_rad, heading)
        return mavlink.MAVLink_attitude_message(_milliseconds(now_s), *angles, 0.0, 0.0, 0.0)

    def _speeds(self) -> Any:
        vehicle = self._autopilot.pilot.vehicle
        east, north, up = vehicle.velocity
        heading = math.degrees(math.atan2(*vehicle.nose)) % 360
        return mavlink.MAVLink_vfr_hud_message(
            vehicle.sensed_eas_m_s,
            math.hypot(east, north),
            round(heading) % 360,
            round(vehicle.throttle * 100),
            vehicle.altitude_m,
            up,
        )


def _milliseconds(now_s: float) -> int:
    return round(now_s * 1000) & 0xFFFFFFFF
