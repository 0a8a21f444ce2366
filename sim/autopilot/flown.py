"""The record of a flight: an instant, a place, a bank and an item a tick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


__all__ = ["Flown"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Flown:
    """A flight, real or simulated.

    Parameters
    ----------
    time_s, place, altitude_m, roll_deg : arrays
        Seconds; (n, 2) metres east and north of home; metres AMSL; degrees.
    index : array
        Number of the item under way.
    """

    time_s: Array
    place: Array
    altitude_m: Array
    roll_deg: Array
    index: NDArray[np.int64]
