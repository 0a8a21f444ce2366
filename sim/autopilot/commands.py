"""Commands, modes and parameters that a ground station sends to the autopilot."""

from __future__ import annotations

import math
import struct
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from pathgene.sim.autopilot.controlled import CommandResult, Controlled
from pathgene.sim.autopilot.feasibility import arming_refusal
from pathgene.sim.autopilot.items import DEGREES, FRAMES, MISSION, Command, Frame
from pathgene.sim.autopilot.parameters import PX4_INTEGERS
from pathgene.sim.autopilot.pilot import Kind, Mode
from pathgene.sim.autopilot.targets import Target


__all__ = ["Commands", "custom_mode"]

_NAMES: dict[Mode, dict[Kind, int]] = {
    Mode.IDLE: {Kind.ARDUPLANE: 12, Kind.PX4: 4 << 16 | 3 << 24},
    Mode.AUTO: {Kind.ARDUPLANE: 10, Kind.PX4: 4 << 16 | 4 << 24},
    Mode.GUIDED: {Kind.ARDUPLANE: 15, Kind.PX4: 4 << 16 | 3 << 24},
    Mode.RTL: {Kind.ARDUPLANE: 11, Kind.PX4: 4 << 16 | 5 << 24},
    Mode.LANDED: {Kind.ARDUPLANE: 10, Kind.PX4: 4 << 16 | 6 << 24},
}
# Values of MAV_PARAM_TYPE.
_INT32, _REAL32 = 6, 9
# Value of the second parameter of a command that arms without checks.
_FORCE = 21196


def custom_mode(mode: Mode, kind: Kind) -> int:
    """Return the number of a mode in the autopilot's heartbeat."""
    return _NAMES[mode][kind]


class Commands:
    """Handler of commands, modes and parameters.

    Parameters
    ----------
    autopilot : Controlled
        The autopilot that the messages change.
    """

    def __init__(self, autopilot: Controlled) -> None:
        self._autopilot = autopilot

    def handle(self, message: Any) -> list[Any]:
        """Return the answers to a message; other messages have none."""
        autopilot = self._autopilot
        match message.get_type():
            case "COMMAND_LONG" | "COMMAND_INT":
                result = self._do(message)
                return [
                    mavlink.MAVLink_command_ack_message(
                        message.command,
                        int(result),
                        target_system=message.get_srcSystem(),
                        target_component=message.get_srcComponent(),
                    )
                ]
            case "SET_MODE":
                self._set_mode(message.custom_mode)
            case "MISSION_SET_CURRENT":
                autopilot.set_current(message.seq)
            case "PARAM_REQUEST_READ":
                name = message.param_id if message.param_index < 0 else self._name(message)
                return self._value(name)
            case "PARAM_REQUEST_LIST":
                return [value for name in autopilot.parameters for value in self._value(name)]
            case "PARAM_SET":
                if message.param_id in autopilot.parameters:
                    value = message.param_value
                    if self._is_integer(message.param_id):
                        value = float(struct.unpack("<i", struct.pack("<f", value))[0])
                    autopilot.parameters[message.param_id] = value
                return self._value(message.param_id)
        return []

    def _name(self, message: Any) -> str:
        names = list(self._autopilot.parameters)
        return names[message.param_index] if message.param_index < len(names) else ""

    def _value(self, name: str) -> list[Any]:
        """Return a parameter; an unknown one has no answer."""
        parameters = self._autopilot.parameters
        if name not in parameters:
            return []
        index = list(parameters).index(name)
        value, kind = parameters[name], _REAL32
        if self._is_integer(name):
            value, kind = struct.unpack("<f", struct.pack("<i", int(value)))[0], _INT32
        return [
            mavlink.MAVLink_param_value_message(name.encode(), value, kind, len(parameters), index)
        ]

    def _is_integer(self, name: str) -> bool:
        """Return whether PX4 sends the bytes of an integer for a parameter."""
        return self._autopilot.kind is Kind.PX4 and name in PX4_INTEGERS

    def _do(self, message: Any) -> CommandResult:
        autopilot = self._autopilot
        match message.command:
            case Command.ARM_DISARM:
                return self._arm(message)
            case Command.MISSION_START:
                return autopilot.fly_mission()
            case Command.DO_SET_MODE:
                number = int(message.param2)
                if autopilot.kind is Kind.PX4:
                    number = number << 16 | int(message.param3) << 24
                return self._set_mode(number)
            case Command.DO_SET_MISSION_CURRENT:
                done = autopilot.set_current(int(message.param1))
                return CommandResult.ACCEPTED if done else CommandResult.DENIED
            case Command.DO_GO_AROUND:
                done = autopilot.pilot.go_around()
                return CommandResult.ACCEPTED if done else CommandResult.DENIED
            case Command.DO_REPOSITION:
                return self._reposition(message)
            case Command.RTL:
                autopilot.return_home("Returning to launch")
                return CommandResult.ACCEPTED
            case Command.REQUEST_MESSAGE:
                return autopilot.tell(int(message.param1))
            case Command.DO_FENCE_ENABLE if autopilot.kind is Kind.ARDUPLANE:
                autopilot.parameters["FENCE_ENABLE"] = float(message.param1 == 1)
                return CommandResult.ACCEPTED
            case Command.DO_CHANGE_SPEED if message.param2 > 0:
                autopilot.pilot.sequencer.speed_m_s = message.param2
                return CommandResult.ACCEPTED
        return CommandResult.UNSUPPORTED

    def _arm(self, message: Any) -> CommandResult:
        """Start or stop the motors; ArduPlane checks its mission unless the command forces it."""
        autopilot = self._autopilot
        arms, is_forced = bool(message.param1), message.param2 == _FORCE
        if arms and autopilot.kind is Kind.ARDUPLANE and not (autopilot.armed or is_forced):
            reason = arming_refusal(autopilot.lists.items[MISSION], autopilot.parameters)
            if reason is not None:
                autopilot.say(f"Arm: {reason}")
                return CommandResult.FAILED
        autopilot.armed = arms
        return CommandResult.ACCEPTED

    def _set_mode(self, number: int) -> CommandResult:
        autopilot = self._autopilot
        numbers = {_NAMES[mode][autopilot.kind]: mode for mode in reversed(Mode)}
        mode = numbers.get(number)
        vehicle = autopilot.pilot.vehicle
        match mode:
            case Mode.AUTO:
                return autopilot.fly_mission()
            case Mode.RTL:
                autopilot.return_home("Returning to launch")
            case Mode.IDLE | Mode.GUIDED:
                autopilot.pilot.guide(Target(vehicle.place, vehicle.altitude_m), mode)
            case _:
                return CommandResult.UNSUPPORTED
        return CommandResult.ACCEPTED

    def _reposition(self, message: Any) -> CommandResult:
        """Fly to a place at once and circle there, in guided mode."""
        autopilot = self._autopilot
        if message.get_type() == "COMMAND_INT":
            lat, lon, z, number = message.x / DEGREES, message.y / DEGREES, message.z, message.frame
        else:
            lat, lon, z, number = message.param5, message.param6, message.param7, 3
        frame = FRAMES.get(number)
        numbers = (lat, lon, z)
        if frame is None or frame == Frame.NONE or not all(map(math.isfinite, numbers)):
            return CommandResult.DENIED
        radius = message.param3 if math.isfinite(message.param3) else 0.0
        place = autopilot.earth.plane.local(lat, lon)
        target = Target(place, z, frame, abs(radius), radius >= 0)
        autopilot.pilot.guide(target)
        return CommandResult.ACCEPTED
