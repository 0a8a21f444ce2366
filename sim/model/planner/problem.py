"""The record of a problem and the sizes of a chip, in the form of the compiled kernels."""

from __future__ import annotations

import dataclasses

import numpy as np

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import ProblemRecord
from pathgene.sim.model.planner.walk import Integers


__all__ = ["problem_vector", "sizes_vector"]

#: Places of the fields of :class:`pathgene.hdl.protocol.planner.ProblemRecord`, in their order.
(
    START_X,
    START_Y,
    START_ALTITUDE,
    GOAL_X,
    GOAL_Y,
    GOAL_ALTITUDE,
    X_LIMIT,
    Y_LIMIT,
    ALTITUDE_LIMIT,
    X_SCALE,
    Y_SCALE,
    RISE,
    CLIMB,
    DESCENT,
    RADIUS,
    BASE,
    DRAG,
    FUEL,
    FUEL_SHIFT,
    KEY_SHIFT,
    BLOCK_SHIFT,
    HAS_ENTRY,
    ENTRY_X,
    ENTRY_Y,
    ENTRY_ALTITUDE,
    HAS_EXIT,
    EXIT_X,
    EXIT_Y,
    EXIT_ALTITUDE,
) = range(29)

#: Places of the sizes.
(
    POPULATION,
    CHILDREN,
    ELITES,
    SURVIVORS,
    MAX_WAYPOINTS,
    RANK_BITS,
    BOX_X,
    BOX_Y,
    BOX_STEPS,
    BLOCKED,
    LANES,
    COORDINATE_BITS,
    ALTITUDE_BITS,
    MEMO_BITS,
) = range(14)


def problem_vector(config: Config, record: ProblemRecord) -> Integers:
    """Return the fields of ``record``, (29,) int64.

    Raises
    ------
    ValueError
        If a field does not fit in the record of ``config``.
    """
    record.pack(config)
    return np.array(list(dataclasses.asdict(record).values()), dtype=np.int64)


def sizes_vector(config: Config, memo: int) -> Integers:
    """Return the sizes of ``config`` and of a memo of ``memo`` rows, (14,) int64."""
    sizes = (
        config.population,
        config.children,
        config.elites,
        config.survivors,
        config.max_waypoints,
        config.slot_bits,
        config.box_cells,
        config.box_cells,
        config.box_steps,
        config.blocked_altitude,
        config.lanes,
        config.coordinate_bits,
        config.altitude_bits,
        max(memo.bit_length() - 1, 0),
    )
    return np.array(sizes, dtype=np.int64)
