"""Parameters of the simulated autopilot: names, defaults and units as the autopilots publish them.

The defaults of ArduPlane come from its parameter documentation (version 4.6), and the set
:data:`SIMULATED_PLANE` from the file that ArduPilot ships for its own simulated plane,
``Tools/autotest/models/plane.parm``.
"""

from __future__ import annotations

from collections.abc import Mapping


__all__ = ["ARDUPLANE", "PX4", "PX4_INTEGERS", "SIMULATED_PLANE", "Parameters"]

#: Parameters of PX4 that are integers, whose bytes it sends.
PX4_INTEGERS = frozenset({"GF_ACTION", "MAV_SYS_ID", "MIS_TKO_LAND_REQ"})

#: Defaults of ArduPlane that matter here. Metres, seconds, degrees, m/s and percent.
ARDUPLANE: Mapping[str, float] = {
    "AIRSPEED_CRUISE": 12.0,
    "AIRSPEED_MIN": 9.0,
    "AIRSPEED_MAX": 22.0,
    "ALT_SLOPE_MIN": 15.0,
    "ALT_SLOPE_MAXHGT": 5.0,
    "FENCE_ACTION": 1.0,
    "FENCE_ALT_MAX": 100.0,
    "FENCE_ENABLE": 0.0,
    "FENCE_TYPE": 4.0,
    "LAND_FLARE_AIM": 50.0,
    "LAND_FLARE_ALT": 3.0,
    "LAND_FLARE_SEC": 2.0,
    "LAND_PITCH_DEG": 0.0,
    "LAND_WIND_COMP": 50.0,
    "LEVEL_ROLL_LIMIT": 5.0,
    "NAVL1_PERIOD": 17.0,
    "NAVL1_DAMPING": 0.75,
    "NAVL1_XTRACK_I": 0.02,
    "PTCH_LIM_MAX_DEG": 20.0,
    "PTCH_LIM_MIN_DEG": -25.0,
    "PTCH2SRV_TCONST": 0.5,
    "PTCH2SRV_RMAX_UP": 0.0,
    "RALLY_LIMIT_KM": 5.0,
    "RLL2SRV_TCONST": 0.5,
    "RLL2SRV_RMAX": 0.0,
    "ROLL_LIMIT_DEG": 45.0,
    "RTL_ALTITUDE": 100.0,
    "RTL_AUTOLAND": 0.0,
    "RTL_RADIUS": 0.0,
    "STALL_PREVENTION": 1.0,
    "SYSID_THISMAV": 1.0,
    "TECS_CLMB_MAX": 5.0,
    "TECS_FLARE_HGT": 1.0,
    "TECS_HDEM_TCONST": 3.0,
    "TECS_INTEG_GAIN": 0.3,
    "TECS_LAND_ARSPD": -1.0,
    "TECS_LAND_DAMP": 0.5,
    "TECS_LAND_PMAX": 10.0,
    "TECS_LAND_SINK": 0.25,
    "TECS_LAND_SPDWGT": -1.0,
    "TECS_LAND_TCONST": 2.0,
    "TECS_PITCH_MAX": 15.0,
    "TECS_PITCH_MIN": 0.0,
    "TECS_PTCH_DAMP": 0.3,
    "TECS_RLL2THR": 10.0,
    "TECS_SINK_MAX": 5.0,
    "TECS_SINK_MIN": 2.0,
    "TECS_SPDWEIGHT": 1.0,
    "TECS_SPD_OMEGA": 2.0,
    "TECS_THR_DAMP": 0.5,
    "TECS_TIME_CONST": 5.0,
    "TECS_VERT_ACC": 7.0,
    "THR_MAX": 75.0,
    "THR_MIN": 0.0,
    "THR_SLEWRATE": 100.0,
    "TRIM_THROTTLE": 45.0,
    "WP_LOITER_RAD": 60.0,
    "WP_MAX_RADIUS": 0.0,
    "WP_RADIUS": 90.0,
}

#: Parameters that ArduPilot ships for its own simulated plane.
SIMULATED_PLANE: Mapping[str, float] = {
    "AIRSPEED_CRUISE": 22.0,
    "AIRSPEED_MIN": 10.0,
    "AIRSPEED_MAX": 30.0,
    "NAVL1_PERIOD": 15.0,
    "PTCH_LIM_MAX_DEG": 25.0,
    "PTCH_LIM_MIN_DEG": -20.0,
    "PTCH2SRV_TCONST": 0.25,
    "PTCH2SRV_RMAX_UP": 90.0,
    "RLL2SRV_TCONST": 0.25,
    "RLL2SRV_RMAX": 90.0,
    "ROLL_LIMIT_DEG": 65.0,
    "THR_MAX": 100.0,
    "TRIM_THROTTLE": 50.0,
    "WP_LOITER_RAD": 80.0,
    "WP_RADIUS": 50.0,
}

#: Defaults of PX4 for a fixed wing.
PX4: Mapping[str, float] = {
    "FW_AIRSPD_MAX": 20.0,
    "FW_AIRSPD_MIN": 10.0,
    "FW_AIRSPD_TRIM": 15.0,
    "FW_P_LIM_MAX": 30.0,
    "FW_P_LIM_MIN": -30.0,
    "FW_P_TC": 0.4,
    "FW_R_LIM": 50.0,
    "FW_R_RMAX": 70.0,
    "FW_R_TC": 0.4,
    "FW_T_ALT_TC": 5.0,
    "FW_T_CLMB_MAX": 5.0,
    "FW_T_CLMB_R_SP": 3.0,
    "FW_T_SINK_MAX": 5.0,
    "FW_T_SINK_R_SP": 2.0,
    "FW_T_SINK_MIN": 2.0,
    "FW_THR_TRIM": 60.0,
    "GF_ACTION": 2.0,
    "MAV_SYS_ID": 1.0,
    "MIS_LND_ABRT_ALT": 30.0,
    "MIS_TKO_LAND_REQ": 2.0,
    "NAV_ACC_RAD": 10.0,
    "NAV_FW_ALT_RAD": 10.0,
    "NAV_LOITER_RAD": 80.0,
    "NPFG_DAMPING": 0.7,
    "NPFG_PERIOD": 10.0,
    "NPFG_ROLL_TC": 0.5,
    "NPFG_SW_DST_MLT": 0.32,
    "RTL_LOITER_RAD": 80.0,
    "RTL_RETURN_ALT": 60.0,
}


class Parameters(dict[str, float]):
    """Parameters by name; later sets replace values of earlier ones.

    Raises
    ------
    KeyError
        If a later set names a parameter that the first one lacks.
    """

    def __init__(self, defaults: Mapping[str, float], *sets: Mapping[str, float]) -> None:
        super().__init__(defaults)
        for values in sets:
            for name, value in values.items():
                if name not in self:
                    raise KeyError(f"The autopilot has no parameter {name}")
                self[name] = float(value)
