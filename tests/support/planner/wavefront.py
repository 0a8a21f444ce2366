"""Maps, problems and words for the tests of the wavefront."""

import numpy as np

from pathgene.hdl.planner.wavefront.layouts import shift_limit
from pathgene.hdl.protocol.planner import BLOCKS, COARSE_BLOCKS, POSITION_FRACTION
from pathgene.sim.model.planner.course import problem_vector
from pathgene.sim.model.planner.definition.score import corner_of
from pathgene.sim.model.planner.definition.wavefront import Blocks
from pathgene.sim.model.planner.wavefront import (
    LEAST,
    LOWEST_X,
    LOWEST_Y,
    measure_blocks,
    measure_distances,
)
from tests.support.planner import cases as planner_cases


class Words:
    """A random source whose words are recorded and include extremes."""

    def __init__(self, rng):
        self._rng = rng
        self.taken = []

    def step(self):
        """Return the words of a step, of which the wavefront takes the first."""
        word = int(self._rng.integers(1 << 64, dtype="uint64"))
        if self._rng.random() < 0.1:
            word = int(self._rng.choice(np.array([0, (1 << 64) - 1], dtype="uint64")))
        self.taken.append(word)
        return word, 0


def terrain(config, rng, *, blocked=0.0):
    """Return a map: hills, with or without many equal corners, and with blocked corners."""
    ground = planner_cases.ground(config, rng, blocked=blocked)
    if rng.random() < 0.8:
        # The last row and column, which are otherwise blocked.
        ground[-1], ground[:, -1] = ground[-2], ground[:, -2]
    if rng.random() < 0.3:
        ground = np.where(ground < config.blocked_altitude, ground >> 4 << 4, ground)
    return ground


def problem(config, rng, *, shift=None, fine=None, any_field=False):
    """Return a problem within the blocks of a random size, 32 or 64 along each edge."""
    make = planner_cases.any_record if any_field else planner_cases.record
    record = make(config, rng)
    if shift is None:
        shift = int(rng.integers(shift_limit(config.coordinate_bits) + 1))
    if fine is None:
        fine = bool(rng.integers(2))
    edge = BLOCKS if fine else COARSE_BLOCKS
    limit = min(config.map_size, edge << shift) - 1 - int(rng.integers(2))
    changes = {"x_limit": limit, "y_limit": limit, "block_shift": shift}
    if not any_field and rng.random() < 0.5:
        # Ends anywhere, so that they are also within smaller blocks.
        for end in ("start", "goal"):
            for axis in "xy":
                changes[f"{end}_{axis}"] = int(rng.integers(limit << POSITION_FRACTION))
    return type(record)(**vars(record) | changes)


def distances_of(config, record):
    """Return the distances between the centres of neighbouring blocks."""
    distances = np.zeros(3, dtype=np.int64)
    measure_distances(problem_vector(config, record), distances)
    return tuple(distances.tolist())


def blocks_of(config, record, ground):
    """Return the blocks of the definition, computed by the compiled kernels."""
    vector = problem_vector(config, record)
    ends = [corner_of(record, end) for end in ("start", "goal")]
    edge = record.blocks
    layers = np.zeros((3, edge, edge), dtype=np.int64)
    measure_blocks(vector, ground, config.blocked_altitude, np.array(ends).ravel(), layers)
    places = [(x, y) for y in range(edge) for x in range(edge)]
    least = {(x, y): int(layers[LEAST, y, x]) for x, y in places if layers[LEAST, y, x] >= 0}
    lowest = {(x, y): (int(layers[LOWEST_X, y, x]), int(layers[LOWEST_Y, y, x])) for x, y in places}
    start, goal = ((x >> record.block_shift, y >> record.block_shift) for x, y, _ in ends)
    return Blocks(least, lowest, start, goal, edge, distances_of(config, record))


def corner(x, y, altitude):
    """Return a corner in the form of its layout."""
    return {"x": x, "y": y, "altitude": altitude}


def layer(values, none, edge):
    """Return a dictionary of blocks as a list by rows, with ``none`` for missing blocks."""
    return [values.get((x, y), none) for y in range(edge) for x in range(edge)]
