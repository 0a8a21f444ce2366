"""The state of the aircraft and of its mission, as heartbeats and MISSION_CURRENT tell it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pathgene.host.mission.autopilot.mavlink_link import Link, NoReplyError
from pathgene.host.mission.autopilot.mission_lists import ARDUPILOT, PX4


__all__ = ["Mission", "begin_at", "flies_mission", "start_refusal"]

# Modes in which the mission is flown, by the kind of autopilot: AUTO of ArduPlane, and mission of
# PX4, whose main mode and sub-mode are the two highest bytes.
_MISSION_MODES = {ARDUPILOT: 10, PX4: 4 << 24 | 4 << 16}
# MISSION_STATE_NO_MISSION; 0 is an autopilot that does not tell.
_UNKNOWN, _NO_MISSION = 0, 1
# Number of MISSION_CURRENT, and MAV_CMD_REQUEST_MESSAGE.
_MISSION_CURRENT, _REQUEST_MESSAGE = 42, 512


@dataclass(frozen=True)
class Mission:
    """The mission of an autopilot as it will be flown.

    Parameters
    ----------
    will_start : bool or None
        False if the autopilot will not start it; None if it does not tell.
    item : int or None
        Number of the item that it begins with; None if it does not tell.
    """

    will_start: bool | None = None
    item: int | None = None


def start_refusal(mission: Mission, texts: Sequence[str]) -> str | None:
    """Return why an autopilot will not start its mission and a remedy, a sentence, or None.

    Parameters
    ----------
    texts : sequence of str
        Texts of the autopilot during the upload.
    """
    if mission.will_start is not False:
        return None
    said = next((text for text in reversed(texts) if "mission" in text.lower()), None)
    reason = "" if said is None else f' ("{said.rstrip(".")}")'
    lands = said is not None and "landing" in said.lower()
    remedy = (
        "end it with a landing (--land), or set MIS_TKO_LAND_REQ to 0 there"
        if lands
        else "see its messages in a ground station"
    )
    return f"The autopilot holds the mission, but will not start it{reason}; {remedy}."


def flies_mission(link: Link, autopilot: int) -> bool:
    """Return whether the aircraft flies its mission, by the latest heartbeat."""
    return link.armed and link.mode == _MISSION_MODES.get(autopilot)


def begin_at(link: Link, item: int, latest: int, autopilot: int) -> Mission:
    """Let the mission begin with an item, and return its state.

    A mission that was left in its middle is continued there, also if another one has been uploaded
    since.

    Parameters
    ----------
    latest : int
        Number of the first item that flies, from ``item`` on, which the autopilot may name.
    """
    if autopilot not in _MISSION_MODES:
        return Mission()
    to = link.system, link.component

    def ask() -> None:
        if autopilot == ARDUPILOT:
            link.mav.mission_set_current_send(*to, item)
        link.mav.command_long_send(*to, _REQUEST_MESSAGE, 0, _MISSION_CURRENT, *[0.0] * 6)

    def is_answer(found: Any) -> bool:
        return bool(item <= found.seq <= latest)

    found = _answer(link, ask, is_answer) or _answer(link, ask, lambda _found: True)
    if found is None:
        return Mission()
    state = getattr(found, "mission_state", _UNKNOWN)
    return Mission(None if state == _UNKNOWN else state != _NO_MISSION, found.seq)


def _answer(link: Link, ask: Any, accept: Any) -> Any:
    try:
        return link.ask(ask, ("MISSION_CURRENT",), accept)
    except (NoReplyError, OSError):
        return None
