"""Draws with chances in proportion to fitness."""

import numpy as np

from pathgene.host.planners.roulette import roulette


def test_roulette_follows_fitness():
    fitness = np.array([1.0, 3.0, 0.5, 1.5])
    draws = roulette(fitness, 60_000, np.random.default_rng(1))
    share = np.bincount(draws, minlength=4) / 60_000
    assert np.abs(share - fitness / fitness.sum()).max() < 0.012
