"""Draws with probabilities proportional to fitness."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


__all__ = ["roulette"]


def roulette(
    fitness: NDArray[np.float64], draws: int, rng: np.random.Generator
) -> NDArray[np.intp]:
    """Draw indices with probabilities proportional to ``fitness`` (m,), with replacement."""
    wheel = np.cumsum(fitness)
    spins = rng.random(draws) * wheel[-1]
    slots: NDArray[np.intp] = np.searchsorted(wheel, spins, side="right")
    return np.minimum(slots, len(fitness) - 1)
