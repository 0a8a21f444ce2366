"""Checks of a mission: PX4's before it starts, and ArduPlane's before it arms.

From PX4's published list of checks for fixed wings: a landing by ``MIS_TKO_LAND_REQ``, an approach
above its landing point, and take-off first. ArduPlane starts every mission, but since version 4.2
it does not arm with a landing sequence that no return uses.
"""

from __future__ import annotations

from collections.abc import Sequence

from pathgene.sim.autopilot.items import FRAMES, Command, Frame, Item
from pathgene.sim.autopilot.parameters import Parameters


__all__ = ["arming_refusal", "refusal"]

# Values of MIS_TKO_LAND_REQ: none, take-off, landing, both, both or none, landing as in missions
# without a take-off in the air.
_TAKEOFF, _LANDING, _BOTH, _SAME = 1, 2, 3, 4
_LANDINGS = (Command.LAND, 85)
_TAKEOFFS = (Command.TAKEOFF, 84)


def refusal(items: Sequence[Item], parameters: Parameters, home_m: float) -> str | None:
    """Return why a mission will not start, in the autopilot's words, or None."""
    flown = [item for item in items if item.navigates or item.command in (84, 85)]
    takes_off = any(item.command in _TAKEOFFS for item in flown)
    lands = any(item.command in _LANDINGS for item in flown)
    if takes_off and flown[0].command not in _TAKEOFFS:
        return "Mission rejected: takeoff not first waypoint item"
    approach = _approach(flown, home_m)
    if approach is not None:
        return approach
    match int(parameters["MIS_TKO_LAND_REQ"]):
        case 1 if not takes_off:
            return "Mission rejected: Takeoff waypoint required."
        case 2 if not lands:
            return "Mission rejected: Landing waypoint/pattern required."
        case 3 if not (takes_off and lands):
            return "Mission rejected: Takeoff or Landing item missing."
        case 4 if takes_off != lands:
            return "Mission rejected: Add Takeoff and Landing item or remove both."
    return None


def arming_refusal(items: Sequence[Item], parameters: Parameters) -> str | None:
    """Return why ArduPlane does not arm, in its words, or None."""
    if parameters.get("RTL_AUTOLAND") != 0:
        return None
    held = {item.command for item in items}
    for command in (Command.DO_LAND_START, Command.DO_RETURN_PATH_START):
        if command in held:
            return f"{command.name} set and RTL_AUTOLAND disabled"
    return None


def _approach(flown: Sequence[Item], home_m: float) -> str | None:
    """Return the fault of the last item before a landing, or None."""
    for number, item in enumerate(flown):
        if item.command != Command.LAND or number == 0:
            continue
        if _altitude(flown[number - 1], home_m) <= _altitude(item, home_m):
            return "Mission rejected: the approach waypoint must be above the landing point."
    return None


def _altitude(item: Item, home_m: float) -> float:
    return item.z + (home_m if FRAMES.get(item.frame) == Frame.HOME else 0.0)
