"""The nearest place of a track, compared with dense samples of all its pieces."""

import math
import time

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.way import WayProblem
from pathgene.host.report.nearest import NearTrack
from pathgene.host.report.via import visits
from pathgene.host.terrain import Terrain


# Samples of a piece, whose ends are among them.
SAMPLES = 4001


def evaluator_of(path, via=()):
    terrain = Terrain("plain", np.zeros((41, 41)), 100, 100)
    return Evaluator(WayProblem(terrain, tuple(map(tuple, (path[0], *via, path[-1])))))


def sampled(track, point, axes):
    """Return the minimum distance of dense samples from a point, and half of their spacing."""
    parts = np.linspace(0, 1, SAMPLES)
    offsets = np.concatenate([piece.points(parts) - point for piece in track.pieces])
    spacing_m = max(piece.length_m for piece in track.pieces) / (SAMPLES - 1)
    return np.linalg.norm(offsets[:, :axes], axis=1).min(), spacing_m / 2


@pytest.mark.parametrize("highest_m", [200, 900, 3000])
def test_agrees_with_dense_samples(highest_m):
    """Steep arcs come nearest to some points far from their place in the plane."""
    rng = np.random.default_rng(highest_m)
    path = np.column_stack((rng.uniform(300, 3700, (6, 2)), rng.uniform(100, highest_m, 6)))
    track = evaluator_of(path).track(path)
    near = NearTrack(track)
    beside = path + rng.normal(0, 40, path.shape)
    anywhere = rng.uniform((0, 0, 0), (4000, 4000, highest_m), (4, 3))
    for point in map(tuple, (*path, *beside, *anywhere)):
        for axes in (2, 3):
            found = near.nearest(point, axes)
            least_m, half_m = sampled(track, point, axes)
            assert found.distance_m <= least_m + 1e-9
            assert math.hypot(found.distance_m, half_m) >= least_m - 1e-9
            assert found.level_m <= found.distance_m + 1e-9
            assert 0 <= found.at_m <= track.length_m + 1e-9


@pytest.mark.parametrize("rise_m", [0.01, 100])
def test_arcs_at_equal_distances_take_no_time(rise_m):
    """All of 2,000 arcs are as far from each of 100 points, so that no arc can be left out."""
    rng = np.random.default_rng(4)
    angle = np.arange(2001) * 2 * math.pi / 5
    height = 200 + rise_m * (np.arange(2001) % 2)
    path = np.column_stack((2000 + 300 * np.cos(angle), 2000 + 300 * np.sin(angle), height))
    via = np.array((2000, 2000, 200 + rise_m / 2)) + rng.uniform(-0.1, 0.1, (100, 3))
    evaluator = evaluator_of(path, via)
    begun_s = time.process_time()
    assert all(visit.missed for visit in visits(evaluator, path))
    assert time.process_time() - begun_s < 2
