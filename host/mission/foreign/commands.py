"""Commands of MAVLink in missions: those that are flown, and those that do not move an aircraft."""

from __future__ import annotations

from enum import IntEnum


__all__ = [
    "CIRCLES",
    "FRAMES",
    "IGNORED",
    "Command",
    "Frame",
    "named",
    "named_frame",
    "radius_place",
]


class Command(IntEnum):
    """Values of MAV_CMD that are flown, or that change how the mission is flown."""

    WAYPOINT = 16
    LOITER_UNLIM = 17
    LOITER_TURNS = 18
    LOITER_TIME = 19
    RETURN_TO_LAUNCH = 20
    LAND = 21
    TAKEOFF = 22
    LOITER_TO_ALT = 31
    DO_JUMP = 177
    DO_CHANGE_SPEED = 178
    DO_LAND_START = 189


#: Commands that circle around a place.
CIRCLES = frozenset(
    {
        Command.LOITER_UNLIM,
        Command.LOITER_TURNS,
        Command.LOITER_TIME,
        Command.LOITER_TO_ALT,
    }
)


def radius_place(command: int) -> int:
    """Return the place of the radius among the parameters of a circle, from 0."""
    return 1 if command == Command.LOITER_TO_ALT else 2


#: Commands that do not move the aircraft, by value.
IGNORED = {
    112: "CONDITION_DELAY",
    114: "CONDITION_DISTANCE",
    115: "CONDITION_YAW",
    181: "DO_SET_RELAY",
    182: "DO_REPEAT_RELAY",
    183: "DO_SET_SERVO",
    184: "DO_REPEAT_SERVO",
    188: "DO_RETURN_PATH_START",
    195: "DO_SET_ROI_LOCATION",
    196: "DO_SET_ROI_WPNEXT_OFFSET",
    197: "DO_SET_ROI_NONE",
    198: "DO_SET_ROI_SYSID",
    200: "DO_CONTROL_VIDEO",
    201: "DO_SET_ROI",
    202: "DO_DIGICAM_CONFIGURE",
    203: "DO_DIGICAM_CONTROL",
    204: "DO_MOUNT_CONFIGURE",
    205: "DO_MOUNT_CONTROL",
    206: "DO_SET_CAM_TRIGG_DIST",
    207: "DO_FENCE_ENABLE",
    211: "DO_GRIPPER",
    212: "DO_AUTOTUNE_ENABLE",
    214: "DO_SET_CAM_TRIGG_INTERVAL",
    218: "DO_AUX_FUNCTION",
    220: "DO_MOUNT_CONTROL_QUAT",
    530: "SET_CAMERA_MODE",
    531: "SET_CAMERA_ZOOM",
    532: "SET_CAMERA_FOCUS",
    534: "SET_CAMERA_SOURCE",
    600: "JUMP_TAG",
    1000: "DO_GIMBAL_MANAGER_PITCHYAW",
    1001: "DO_GIMBAL_MANAGER_CONFIGURE",
    2000: "IMAGE_START_CAPTURE",
    2001: "IMAGE_STOP_CAPTURE",
    2003: "DO_TRIGGER_CONTROL",
    2500: "VIDEO_START_CAPTURE",
    2501: "VIDEO_STOP_CAPTURE",
    42600: "DO_WINCH",
}

# Names of other commands, for refusals.
_OTHERS = {
    23: "NAV_LAND_LOCAL",
    24: "NAV_TAKEOFF_LOCAL",
    25: "NAV_FOLLOW",
    30: "NAV_CONTINUE_AND_CHANGE_ALT",
    32: "DO_FOLLOW",
    80: "NAV_ROI",
    81: "NAV_PATHPLANNING",
    82: "NAV_SPLINE_WAYPOINT",
    83: "NAV_ALTITUDE_WAIT",
    84: "NAV_VTOL_TAKEOFF",
    85: "NAV_VTOL_LAND",
    92: "NAV_GUIDED_ENABLE",
    93: "NAV_DELAY",
    94: "NAV_PAYLOAD_PLACE",
    113: "CONDITION_CHANGE_ALT",
    176: "DO_SET_MODE",
    179: "DO_SET_HOME",
    185: "DO_FLIGHTTERMINATION",
    186: "DO_CHANGE_ALTITUDE",
    190: "DO_RALLY_LAND",
    191: "DO_GO_AROUND",
    192: "DO_REPOSITION",
    193: "DO_PAUSE_CONTINUE",
    208: "DO_PARACHUTE",
    210: "DO_INVERTED_FLIGHT",
    213: "NAV_SET_YAW_SPEED",
    215: "DO_SET_REVERSE",
    222: "DO_GUIDED_LIMITS",
    223: "DO_ENGINE_CONTROL",
    252: "OVERRIDE_GOTO",
    601: "DO_JUMP_TAG",
    3000: "DO_VTOL_TRANSITION",
    42700: "DO_SEND_SCRIPT_MESSAGE",
    42702: "NAV_SCRIPT_TIME",
    42703: "NAV_ATTITUDE_TIME",
}


class Frame(IntEnum):
    """Surfaces that heights of items are measured from."""

    AMSL = 0
    HOME = 3
    GROUND = 10


#: Values of MAV_FRAME with a place on Earth; the newer ones mean the same.
FRAMES = {
    0: Frame.AMSL,
    5: Frame.AMSL,
    3: Frame.HOME,
    6: Frame.HOME,
    10: Frame.GROUND,
    11: Frame.GROUND,
}

_OTHER_FRAMES = {
    1: "LOCAL_NED",
    2: "MISSION",
    4: "LOCAL_ENU",
    7: "LOCAL_OFFSET_NED",
    8: "BODY_NED",
    9: "BODY_OFFSET_NED",
    12: "BODY_FRD",
    20: "LOCAL_FRD",
    21: "LOCAL_FLU",
}


def named(command: int) -> str:
    """Return a command by its name, without the prefix of MAVLink, and its value."""
    own = {Command.DO_JUMP: "DO_JUMP", Command.DO_CHANGE_SPEED: "DO_CHANGE_SPEED"}
    own |= {each: f"NAV_{each.name}" for each in Command if each < Command.DO_JUMP}
    own[Command.DO_LAND_START] = "DO_LAND_START"
    names = {**IGNORED, **_OTHERS, **{int(value): name for value, name in own.items()}}
    return f"{names[command]} ({command})" if command in names else f"the command {command}"


def named_frame(frame: int) -> str:
    """Return a frame by its name and value."""
    return f"{_OTHER_FRAMES[frame]} ({frame})" if frame in _OTHER_FRAMES else str(frame)
