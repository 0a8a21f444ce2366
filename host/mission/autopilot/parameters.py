"""Parameters of an autopilot: they are read, set and read back by MAVLink's parameter protocol.

ArduPilot carries all values as numbers in single precision; PX4 carries the bytes of its integers
(https://mavlink.io/en/services/parameter.html).
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping
from typing import Any

from pathgene.host.mission.autopilot.mavlink_link import Link, NoReplyError
from pathgene.host.mission.autopilot.mission_lists import PX4


__all__ = ["read_parameters", "set_parameters"]

# Values of MAV_PARAM_TYPE: a signed integer of 32 bits, and a number in single precision.
_INT32, _REAL32 = 6, 9
# Maximum difference of a value that has been set and read back, as a share.
_ROUNDING = 1e-6


def read_parameters(
    link: Link, autopilot: int, wanted: Iterable[tuple[str, ...]]
) -> dict[str, float]:
    """Return values of parameters by name; those that the autopilot does not give are missing.

    Parameters
    ----------
    wanted : iterable of tuple of str
        Names of the same parameter in several versions, of which the autopilot has one.
    """
    missing = list(wanted)
    found: dict[str, float] = {}
    is_asked = False

    def ask() -> None:
        nonlocal is_asked
        if not is_asked:
            for name in (name for names in missing for name in names):
                link.mav.param_request_read_send(link.system, link.component, name.encode(), -1)
        is_asked = False

    def is_missing(message: Any) -> bool:
        return any(message.param_id in names for names in missing)

    try:
        while missing:
            message = link.ask(ask, ("PARAM_VALUE",), is_missing)
            found[message.param_id] = _value(message, autopilot)
            missing = [names for names in missing if message.param_id not in names]
            # Further answers are on their way.
            is_asked = True
    except (NoReplyError, OSError):
        pass
    return found


def set_parameters(link: Link, autopilot: int, values: Mapping[str, float]) -> list[str]:
    """Set parameters and read each back; return the names of those that could not be set.

    After one that cannot be set, the earlier ones get their former values back.
    """
    former = read_parameters(link, autopilot, [(name,) for name in values])
    done: list[str] = []
    for name, value in values.items():
        if name not in former or not _set(link, autopilot, name, value):
            for each in (*done, *([name] if name in former else [])):
                _set(link, autopilot, each, former[each])
            return [name]
        done.append(name)
    return []


def _set(link: Link, autopilot: int, name: str, value: float) -> bool:
    """Set a parameter; return whether the autopilot then has the value."""
    is_integer = autopilot == PX4 and float(value).is_integer() and name in _PX4_INTEGERS
    sent = struct.unpack("<f", struct.pack("<i", int(value)))[0] if is_integer else value
    kind = _INT32 if is_integer else _REAL32

    def ask() -> None:
        link.mav.param_set_send(link.system, link.component, name.encode(), sent, kind)

    def is_answer(message: Any) -> bool:
        return bool(message.param_id == name)

    try:
        message = link.ask(ask, ("PARAM_VALUE",), is_answer)
    except (NoReplyError, OSError):
        return False
    return abs(_value(message, autopilot) - value) <= _ROUNDING * max(abs(value), 1.0)


# Integers among the parameters that are set.
_PX4_INTEGERS = ("GF_ACTION",)


def _value(message: Any, autopilot: int) -> float:
    """Return the value of a message PARAM_VALUE."""
    if autopilot == PX4 and message.param_type == _INT32:
        return float(struct.unpack("<i", struct.pack("<f", message.param_value))[0])
    return float(message.param_value)
