"""Wind: a steady velocity of the air, and turbulence with a seed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.sim.autopilot.dynamics import STEP_S, STEPS


__all__ = ["Wind"]


@dataclass(frozen=True)
class Wind:
    """Steady wind, and gusts that are first-order Gauss-Markov processes.

    Parameters
    ----------
    east_m_s, north_m_s : float
        Velocity of the air.
    gusts_m_s : float
        Standard deviation of the gusts along and across, 0 for none.
    up : float
        Standard deviation of the gusts upwards as a share of ``gusts_m_s``.
    gust_s : float
        Time in which a gust decays. Dryden's longitudinal gusts decay in their length of 200 m at
        300 m of height divided by the airspeed, 8 s at 25 m/s.
    seed : int
        The same seed gives the same gusts.
    """

    east_m_s: float = 0.0
    north_m_s: float = 0.0
    gusts_m_s: float = 0.0
    up: float = 0.5
    gust_s: float = 8.0
    seed: int = 0

    def samples(self) -> WindSamples:
        """Return the samples of a flight, from its beginning."""
        return WindSamples(self)


class WindSamples:
    """The wind of a flight, :data:`~pathgene.sim.autopilot.dynamics.STEPS` samples at a time."""

    def __init__(self, wind: Wind) -> None:
        self._steady = np.array([wind.east_m_s, wind.north_m_s, 0.0])
        self._random = np.random.default_rng(wind.seed)
        self._keep = math.exp(-STEP_S / wind.gust_s)
        sizes = wind.gusts_m_s * np.array([1.0, 1.0, wind.up])
        self._spread = sizes * math.sqrt(1 - self._keep**2)
        self._gust = sizes * self._random.normal(size=3)
        self._is_calm = wind.gusts_m_s == 0
        self._flat = np.tile(self._steady, (STEPS, 1))

    def next(self) -> NDArray[np.float64]:
        """Return the next samples as (STEPS, 3) float64, m/s east, north and up."""
        if self._is_calm:
            return self._flat
        kicks = self._random.normal(size=(STEPS, 3)) * self._spread
        made = np.empty((STEPS, 3))
        for step in range(STEPS):
            self._gust = self._gust * self._keep + kicks[step]
            made[step] = self._gust
        made += self._steady
        return made
