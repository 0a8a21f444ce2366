"""Arguments of the kernels: a problem on a chip, the state of a run, and a population."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import ProblemRecord
from pathgene.sim.model.planner.random_words import Words
from pathgene.sim.model.planner.walk import Ground, Integers


__all__ = [
    "Course",
    "Members",
    "Route",
    "Scratch",
    "Surroundings",
    "problem_vector",
    "sizes_vector",
]


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


class Course(NamedTuple):
    """A problem on a chip, constant throughout a run.

    Parameters
    ----------
    problem, sizes : (29,), (14,) int64
        See :mod:`pathgene.sim.model.planner.course`.
    ground : (map_size, map_size) uint16
        Highest cell around each corner.
    """

    problem: Integers
    sizes: Integers
    ground: Ground


class Scratch(NamedTuple):
    """Memo, counters and work space of the evaluation of paths.

    Parameters
    ----------
    memo : (rows, 4) int64
        Memo of segments.
    delays, counters : (n,) int64
        Latencies of the chip and counters of the run; see :mod:`pathgene.sim.model.planner.cycles`.
    work : (WORK_ROWS, points) int64
        Work space of a score.
    """

    memo: Integers
    delays: Integers
    counters: Integers
    work: Integers


class Surroundings(NamedTuple):
    """Random source, observer and work space of the generations of a run.

    Parameters
    ----------
    watched : (WATCHED,) int64
        Progress that another thread reads, and the stop that it requests.
    spare : (7, slots + 1) int64
        Work space of a generation.
    """

    words: Words
    watched: Integers
    spare: Integers


class Members(NamedTuple):
    """A population; the arrays of a run have an additional first axis, the island.

    Parameters
    ----------
    paths : (slots, points, 4) int64
        Rows x, y, step and margin, including start and goal.
    points, keys : (slots,) int64
        Number of points of each path, including its ends, and its key.
    order : (slots + 1,) int64
        Slots of the population, best first.
    """

    paths: Integers
    points: Integers
    keys: Integers
    order: Integers


class Route(NamedTuple):
    """A route over the blocks of the map.

    Parameters
    ----------
    blocks : (3, edge, edge) int64
        Minimum ground of each block, and the x and y of a corner with that ground.
    surface : (edge, edge) int64
        Altitude of the surface along which the route leads.
    places : (edge**2, 2) int64
        Blocks x, y of the route; only the first ``length`` count.
    length : int
        Blocks of the route.
    turns : (max_waypoints + 1, 2) int64
        Blocks x, y at which the route turns; only the first ``followed`` count.
    followed : int
        Number of turns that the seeds follow; 0 if they are evenly spaced.
    guide : (max_waypoints, 3) int64
        Waypoints of the guide; only the first ``guided`` count.
    guided : int
        Number of waypoints of the guide that the seeds follow; 0 if they follow the route.
    """

    blocks: Integers
    surface: Integers
    places: Integers
    length: int
    turns: Integers
    followed: int
    guide: Integers
    guided: int
