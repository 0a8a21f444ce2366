"""Height and speed control of PX4, in its main features.

An altitude reference runs after the demand with a time constant of ``FW_T_ALT_TC`` at no more than
``FW_T_CLMB_R_SP`` up and ``FW_T_SINK_R_SP`` down. Energy and its balance follow as in
:class:`~pathgene.sim.autopilot.height.Tecs`, which PX4's control descends from. Unlike ArduPlane,
PX4 neither stops nor slows its reference where throttle or pitch are at a limit.
"""

from __future__ import annotations

from pathgene.sim.autopilot.height import Demand, Tecs, Vertical
from pathgene.sim.autopilot.parameters import ARDUPLANE, Parameters
from pathgene.sim.autopilot.targets import Approach


__all__ = ["Px4Height"]


class _Energy(Tecs):
    """Energy control that follows a reference of height as it is."""

    def _delay_height(self, height_m: float, dt_s: float) -> None:
        self._height_rate = (height_m - self.height_m) / dt_s
        self.height_m = height_m


class Px4Height:
    """State of the height control.

    Attributes
    ----------
    height_m : float
        The reference that the aircraft follows.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        get = parameters
        # The reference is delayed here, so the energy control delays it no further.
        self._energy = _Energy(
            Parameters(
                ARDUPLANE,
                {
                    "AIRSPEED_CRUISE": get["FW_AIRSPD_TRIM"],
                    "AIRSPEED_MIN": get["FW_AIRSPD_MIN"],
                    "AIRSPEED_MAX": get["FW_AIRSPD_MAX"],
                    "PTCH_LIM_MAX_DEG": get["FW_P_LIM_MAX"],
                    "PTCH_LIM_MIN_DEG": get["FW_P_LIM_MIN"],
                    "TECS_CLMB_MAX": get["FW_T_CLMB_MAX"],
                    "TECS_SINK_MAX": get["FW_T_SINK_MAX"],
                    "TECS_PITCH_MAX": 0.0,
                    "TECS_SINK_MIN": get["FW_T_SINK_MIN"],
                    "THR_MAX": 100.0,
                    "TRIM_THROTTLE": get["FW_THR_TRIM"],
                },
            )
        )
        self._is_new = True
        self.height_m = 0.0

    def reset(self) -> None:
        """Begin again from the measured height at the next call."""
        self._is_new = True
        self._energy.reset()

    def update(
        self,
        now: Vertical,
        height_m: float,
        eas_m_s: float,
        load: float,
        dt_s: float,
        approach: Approach | None = None,
    ) -> Demand:
        """Return pitch and throttle for a demanded height and equivalent airspeed.

        PX4 has no landing of its own here: the height is delayed on the approach, too.
        """
        if self._is_new:
            self._is_new = False
            self.height_m = now.height_m
        get = self._parameters
        rate = (height_m - self.height_m) / get["FW_T_ALT_TC"]
        rate = min(max(rate, -get["FW_T_SINK_R_SP"]), get["FW_T_CLMB_R_SP"])
        self.height_m += rate * dt_s
        return self._energy.update(now, self.height_m, eas_m_s, load, dt_s)
