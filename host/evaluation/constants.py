"""Constants of the evaluation, and the types of arrays that its compiled kernels take."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


__all__ = [
    "COLLINEAR_RAD",
    "COORDINATE_LIMIT_M",
    "SLOPE_TOLERANCE_RAD",
    "TURN_AT_END_RAD",
    "VOID_HEIGHT_M",
    "Constants",
    "Course",
    "Flags",
    "Floats",
    "Point",
    "Scratch",
]

# Height of a void: above every path, and finite, so that its product with a weight of 0 is 0.
VOID_HEIGHT_M = 1e300
# Beyond this a coordinate is not a place on a map: it keeps the number of samples finite.
COORDINATE_LIMIT_M = 1e7

# Rounding turns a waypoint on a straight line by up to about 1e-15 rad: no turn at all.
COLLINEAR_RAD = 1e-12
# Sharpest turn from a fixed heading at the start, or to one at the goal: the arc of a sharper one
# would begin more than a radius before the start, and end as far beyond the goal.
TURN_AT_END_RAD = 0.5 * math.pi + 1e-9
# A slope is too steep beyond the limit and this.
SLOPE_TOLERANCE_RAD = 1e-9

# The arrays of the kernels: rasters are flat, a path is (max_n, 3) float64.
Floats = NDArray[np.float64]
Flags = NDArray[np.uint8]
Point = tuple[float, float, float]


class Constants(NamedTuple):
    """Constants of a problem, the same for all its paths. Metres, newtons, seconds, radians.

    ``rows`` and ``columns`` are the shape of the rasters. With ``sampled`` 0, not 1, nothing is
    sampled: d_ut and d_nf are 0. ``burn_per_m`` is sfc / eta, 1/m; ``base_m`` is the
    altitude that the cost of altitude counts from; ``utopia_area_m2`` is a_utopia * l_utopia.

    The last fields belong to the rules of safe flight. With ``as_paper`` they are 0, and the limits
    among them are infinite. ``in_air`` is 1 where vertical speeds limit slopes, as in wind.
    ``roofed`` is 1 where the negated roofs follow the raster of the ground. ``start_east`` and
    ``start_north`` are the unit vector of the heading at the start, 0 and 0 if the heading is free;
    the goal has the same two fields. ``headings`` is the number of fixed headings.
    """

    dx_m: float
    dy_m: float
    rows: int
    columns: int
    ds_m: float
    sampled: int
    turn_radius_m: float
    max_climb_rad: float
    max_descent_rad: float
    weight: float
    airspeed_m_s: float
    wing_area_m2: float
    drag_coefficient: float
    induced_drag_factor: float
    burn_per_m: float
    wind_x_m_s: float
    wind_y_m_s: float
    base_m: float
    utopia_area_m2: float
    utopia_fuel: float
    in_air: int
    roofed: int
    headings: int
    climb_m_s: float
    descent_m_s: float
    thrust: float
    fuel: float
    ceiling_m: float
    start_east: float
    start_north: float
    goal_east: float
    goal_north: float


class Course(NamedTuple):
    """Rasters and constants of a problem: the kernels evaluate every path of it over these.

    Parameters
    ----------
    ground : (rows * columns,) float64, metres
        Flat raster, ``VOID_HEIGHT_M`` for a void; the negated roofs follow where ``c.roofed`` is 1.
    zoned : (rows * columns,) float64, metres
        The ground with NaN in no-fly zones, so that one load usually answers both questions.
    """

    ground: Floats
    zoned: Floats
    c: Constants


class Scratch(NamedTuple):
    """Work space of the kernels, made by ``scratch``, for one path.

    Parameters
    ----------
    pieces : (2 * max_n, PIECE_FIELDS) float64
        The arc at the start; of each segment, the straight part and the arc at its end.
    """

    turns: Floats
    pieces: Floats
