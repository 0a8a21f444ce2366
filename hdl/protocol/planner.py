"""Numbers of the planner core: fixed points, keys of paths, and the record of a problem.

Gateware, model and host read them here. The module is pure Python.
"""

from __future__ import annotations

import enum
import functools
from dataclasses import dataclass

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.layout import Field, Layout, sized


__all__ = [
    "ALTITUDE_FRACTION",
    "BASE_BITS",
    "BEND_BITS",
    "BLOCKS",
    "COARSE_BLOCKS",
    "DRAG_FRACTION",
    "EDGES",
    "EDGE_BITS",
    "EXCESS_BITS",
    "FAR",
    "FUEL_BITS",
    "HIT_BITS",
    "MAX_HALF_TURN",
    "MEMO_ROWS",
    "POSITION_FRACTION",
    "RADIUS_BITS",
    "RISE_BITS",
    "RISE_FRACTION",
    "SCALE_FRACTION",
    "SEED_WAYPOINTS",
    "SHARE_BITS",
    "SHARPEST_BITS",
    "SLOPE_BITS",
    "SLOPE_FRACTION",
    "STEEP",
    "SWEEPS",
    "TURN_FRACTION",
    "VALUE_BITS",
    "NoFlyShape",
    "PathClass",
    "ProblemRecord",
    "no_fly_request",
    "problem_request",
    "seed_waypoints",
    "turn_table",
]

#: Fraction bits of a position in cells. A unit of length is 2**-8 of the longer side of a cell.
POSITION_FRACTION = 8
#: Fraction bits of an altitude in steps.
ALTITUDE_FRACTION = 4
#: Fraction bits of the two sides of a cell, as shares of the longer one.
SCALE_FRACTION = 14
#: Fraction bits and width of a slope: sixteenths of a step per unit of length.
SLOPE_FRACTION, SLOPE_BITS = 12, 24
#: Fraction bits and width of the units of length in a sixteenth of a step.
RISE_FRACTION, RISE_BITS = 16, 20
#: Width of the turning radius in units of length.
RADIUS_BITS = 18
#: Width of the altitude of step 0 above the datum, in thirty-seconds of a step, two's complement.
BASE_BITS = 25
#: Fraction bits, and width, of the drag as a share of the weight. :data:`RISE_FRACTION` equals it,
#: so that drag times length and rise add up.
DRAG_FRACTION = 16
#: Width of the weight of the fuel in the cost.
FUEL_BITS = 16
#: Fraction bits of the tangent of half a turn, and of a turn in radians.
TURN_FRACTION = 12
#: Bits of the tangents of half turns before their fractions: at 16 or more, no arc is possible.
SHARPEST_BITS = 4
#: Fraction bits of a tangent as a share of its segment.
SHARE_BITS = 16
#: Penalty of a segment that is too steep, in addition to its excess: a quarter of a cell's length.
STEEP = 1 << POSITION_FRACTION - 2
#: Fraction bits of an excess in sixteenths of a step: a sixteenth counts as 4 units of length.
EXCESS_BITS = 2
#: Binary logarithm of the penalty of a colliding corner in units of length: four cells.
HIT_BITS = POSITION_FRACTION + 2
#: Maximum tangent of half a turn that the arc's length distinguishes: turns of about 152 degrees.
MAX_HALF_TURN = 4
#: Entries of the table of turns for each unit of the tangent.
_TURN_STEPS = 64

#: Width in a path's key of the cost of a feasible path, or of the penalty of an infeasible one.
VALUE_BITS = 28
#: Maximum blocks along each edge of the wavefront's map, and the number if as many are enough for
#: the limits of a problem: a quarter of the blocks take a quarter of the cycles.
BLOCKS, COARSE_BLOCKS = 64, 32
#: Cost of a block from which no route leads to the goal: greater than the cost of any route.
FAR = 1 << 30
#: Sweeps over the blocks, forward and backward, after which both relaxations of the wavefront end.
SWEEPS = 64
#: Rows of the memo of segments.
MEMO_ROWS = 512
#: Minimum and maximum waypoints of a first path whose waypoints are evenly spaced, limited by the
#: longest path.
SEED_WAYPOINTS = 4, 16

#: Maximum edges of a shape that becomes blocked.
EDGES = 8
#: Width of an edge's fall towards east and north, two's complement, and of a bend.
EDGE_BITS, BEND_BITS = 16, 8
_EDGE = "at", "east", "north"


class PathClass(enum.IntEnum):
    """Upper bits of a path's key: the lower, the better."""

    #: Feasible: nothing collides, no slope is too steep, every arc fits. The value is the cost.
    FEASIBLE = 0
    #: Too costly to be checked for collisions, but otherwise feasible. The value is the cost.
    GIVEN_UP = 1
    #: The value is the penalty.
    INFEASIBLE = 2
    #: No path, or a copy of a better path.
    VOID = 3


@dataclass(frozen=True, kw_only=True)
class ProblemRecord:
    """A problem as integers of the chip.

    :func:`problem_request` says meaning, unit and range of each field. Positions are on the lattice
    of corners. The heading at start or goal is fixed by an *entry*, a point before the start, or by
    an *exit*, a point after the goal.
    """

    start_x: int
    start_y: int
    start_altitude: int
    goal_x: int
    goal_y: int
    goal_altitude: int
    x_limit: int
    y_limit: int
    altitude_limit: int
    x_scale: int
    y_scale: int
    rise: int
    climb: int
    descent: int
    radius: int
    base: int
    drag: int
    fuel: int
    fuel_shift: int
    key_shift: int
    block_shift: int
    has_entry: int = 0
    entry_x: int = 0
    entry_y: int = 0
    entry_altitude: int = 0
    has_exit: int = 0
    exit_x: int = 0
    exit_y: int = 0
    exit_altitude: int = 0

    def pack(self, config: Config) -> bytes:
        """Return the record as :func:`problem_request` lays it out.

        Raises
        ------
        ValueError
            If a field does not fit.
        """
        half = 1 << BASE_BITS - 1
        if not -half <= self.base < half:
            raise ValueError(f"base must fit in {BASE_BITS} bits with its sign, not {self.base!r}")
        values = dict(vars(self))
        values["base"] %= 1 << BASE_BITS
        return problem_request(config).pack(**values)

    def is_valid(self, config: Config) -> bool:
        """Return whether a chip of ``config`` accepts the record: every field is within its range.

        Limits are on the map, a waypoint is below the blocked altitude, both scales are at most 1,
        and the blocks are no larger than the map needs but cover all corners within the limits.
        """
        most_shift = max(config.coordinate_bits - (COARSE_BLOCKS.bit_length() - 1), 0)
        return (
            self.altitude_limit < config.blocked_altitude
            and max(self.x_scale, self.y_scale) <= 1 << SCALE_FRACTION
            and self.block_shift <= most_shift
            and max(self.x_limit, self.y_limit) >> self.block_shift < BLOCKS
        )

    @property
    def blocks(self) -> int:
        """Blocks along each edge of the wavefront's map: 32 if they cover the limits, else 64."""
        furthest = max(self.x_limit, self.y_limit) >> self.block_shift
        return COARSE_BLOCKS if furthest < COARSE_BLOCKS else BLOCKS

    @classmethod
    def unpack(cls, config: Config, payload: bytes) -> ProblemRecord:
        """Return the record in ``payload``, the inverse of :meth:`pack`."""
        values = problem_request(config).unpack(payload)
        values["base"] -= (values["base"] >> BASE_BITS - 1) << BASE_BITS
        return cls(**values)


@dataclass(frozen=True, kw_only=True)
class NoFlyShape:
    """Corners to block: all corners of a box that are on the inner side of every edge.

    Corner (x, y) is on the inner side of an edge if ``at + east * u + north * v``, with u = x -
    first_x and v = y - first_y, is 0 or more. The first edge may bend: then
    ``bend_x * u**2 + bend_y * v**2`` is subtracted, so that a shape with one edge can be a disc for
    any cell sides.

    Parameters
    ----------
    first_x, first_y, last_x, last_y : int
        The box: its first and last corners.
    edges : tuple of (int, int, int)
        Up to :data:`EDGES` of ``at``, ``east`` and ``north``.
    bend_x, bend_y : int
        0 for a convex polygon.
    """

    first_x: int
    first_y: int
    last_x: int
    last_y: int
    edges: tuple[tuple[int, int, int], ...]
    bend_x: int = 0
    bend_y: int = 0

    @property
    def drawing_cycles(self) -> int:
        """Cycles in which the shape is offered to the drawer, which takes it in the last one."""
        return (self.last_x - self.first_x + 1) * (self.last_y - self.first_y + 1) + 2

    def pack(self, config: Config) -> bytes:
        """Return the shape as :func:`no_fly_request` lays it out.

        Raises
        ------
        ValueError
            If a field does not fit, there are too many edges, or a bend without an edge.
        """
        if len(self.edges) > EDGES:
            raise ValueError(f"A shape must have at most {EDGES} edges, not {len(self.edges)}")
        if (self.bend_x or self.bend_y) and not self.edges:
            raise ValueError("A shape with a bend must have an edge, which bends")
        widths = dict(no_fly_request(config).fields)
        values = {name: getattr(self, name) for name in widths if hasattr(self, name)}
        # All corners are on the inner side of an edge of zeros.
        edges = *self.edges, *[(0, 0, 0)] * (EDGES - len(self.edges))
        for i, edge in enumerate(edges):
            for name, value in zip(_EDGE, edge, strict=True):
                field = f"{name}_{i}"
                half = 1 << widths[field] - 1
                if not -half <= value < half:
                    raise ValueError(
                        f"{field} must fit in {widths[field]} bits with its sign, not {value!r}"
                    )
                values[field] = value % (2 * half)
        return no_fly_request(config).pack(**values)

    def is_valid(self) -> bool:
        """Return whether a chip accepts the shape: its box has at least one corner."""
        return self.first_x <= self.last_x and self.first_y <= self.last_y

    @classmethod
    def unpack(cls, config: Config, payload: bytes) -> NoFlyShape:
        """Return the shape in ``payload`` with all edges, the inverse of :meth:`pack`."""
        layout = no_fly_request(config)
        values = layout.unpack(payload)
        widths = dict(layout.fields)

        def signed(field: str) -> int:
            value = values.pop(field)
            return value - (value >> widths[field] - 1 << widths[field])

        edges = [tuple(signed(f"{name}_{i}") for name in _EDGE) for i in range(EDGES)]
        return cls(**values, edges=tuple((at, east, north) for at, east, north in edges))


@functools.lru_cache
def no_fly_request(config: Config) -> Layout:
    """Return the layout of a :class:`NoFlyShape`."""
    bits = config.coordinate_bits
    edges = [
        (
            Field(
                f"at_{i}",
                bits + EDGE_BITS + 1,
                "two's complement",
                "Value of an edge at the first corner",
            ),
            Field(f"east_{i}", EDGE_BITS, "two's complement", "Its gain per corner eastwards"),
            Field(f"north_{i}", EDGE_BITS, "two's complement", "The same northwards"),
        )
        for i in range(EDGES)
    ]
    return Layout(
        (
            Field("first_x", bits, "0 … last_x", "First corner of the box", "coordinate_bits"),
            Field("first_y", bits, "0 … last_y", "The same northwards", "coordinate_bits"),
            Field("last_x", bits, "0 … map_size − 1", "Last corner of the box", "coordinate_bits"),
            Field("last_y", bits, "0 … map_size − 1", "The same northwards", "coordinate_bits"),
            Field("bend_x", BEND_BITS, "any", "Bend of edge 0 eastwards"),
            Field("bend_y", BEND_BITS, "any", "The same northwards"),
            *(field for edge in edges for field in edge),
        )
    )


@functools.lru_cache
def problem_request(config: Config) -> Layout:
    """Return the layout of a :class:`ProblemRecord`."""
    position = config.coordinate_bits + POSITION_FRACTION
    altitude = config.altitude_bits + ALTITUDE_FRACTION

    return Layout(
        (
            Field("start_x", position, "any", "Start, 1/256 of a cell from the first corner"),
            Field("start_y", position, "any", "The same northwards"),
            Field("start_altitude", altitude, "any", "Start, 1/16 of a step"),
            Field("goal_x", position, "any", "Goal"),
            Field("goal_y", position, "any", "The same northwards"),
            Field("goal_altitude", altitude, "any", "Goal, 1/16 of a step"),
            sized(
                config, "x_limit", "coordinate_bits", "0 … map_size − 1", "Highest x of a waypoint"
            ),
            sized(
                config, "y_limit", "coordinate_bits", "0 … map_size − 1", "Highest y of a waypoint"
            ),
            sized(
                config,
                "altitude_limit",
                "altitude_bits",
                "0 … blocked − 1",
                "Highest altitude of a waypoint",
            ),
            Field(
                "x_scale",
                SCALE_FRACTION + 1,
                "0 … 2¹⁴",
                "Side of a cell in x, 2⁻¹⁴ of the longer side",
            ),
            Field("y_scale", SCALE_FRACTION + 1, "0 … 2¹⁴", "Side of a cell in y"),
            Field("rise", RISE_BITS, "any", "1/16 of a step in units of length, 2⁻¹⁶"),
            Field(
                "climb",
                SLOPE_BITS,
                "any",
                "Steepest climb, 1/16 of a step per unit of length, 2⁻¹²",
            ),
            Field("descent", SLOPE_BITS, "any", "Steepest descent"),
            Field("radius", RADIUS_BITS, "any", "Turning radius, units of length"),
            Field("base", BASE_BITS, "two's complement", "Altitude of step 0, 1/32 of a step"),
            Field("drag", DRAG_FRACTION, "any", "Drag of level flight, 2⁻¹⁶ of the weight"),
            Field("fuel", FUEL_BITS, "any", "Weight of fuel in the cost"),
            Field("fuel_shift", 5, "any", "Right shift of that weight"),
            Field("key_shift", 6, "any", "Right shift of a cost that makes it a value"),
            Field(
                "block_shift",
                4,
                "0 … ⌈log₂ map_size⌉ − 5, or 0",
                "Corners of a block, as a power of two; 64 × 64 blocks if 32 × 32 do not reach the "
                "limits",
            ),
            Field("has_entry", 1, "0, 1", "1: a point before the start fixes the heading there"),
            Field(
                "entry_x", position, "any", "Point before the start, which counts only in the score"
            ),
            Field("entry_y", position, "any", "The same northwards"),
            Field("entry_altitude", altitude, "any", "1/16 of a step"),
            Field("has_exit", 1, "0, 1", "1: a point beyond the goal fixes the heading there"),
            Field("exit_x", position, "any", "Point beyond the goal"),
            Field("exit_y", position, "any", "The same northwards"),
            Field("exit_altitude", altitude, "any", "1/16 of a step"),
        )
    )


def seed_waypoints(longest: int) -> tuple[int, int]:
    """Return the minimum and the maximum waypoints of a first path, given the ``longest`` path."""
    fewest, most = (min(count, longest) for count in SEED_WAYPOINTS)
    return fewest, most


def turn_table() -> tuple[int, ...]:
    """Return turns by the tangent of half the turn: ``floor(2 atan(i / 64) * 4096)``, i = 0..257.

    It has one entry more than :data:`MAX_HALF_TURN` requires, so that a look-up interpolates
    without a special case. It is computed exactly, by Euler's series in integers.
    """
    guard = 64
    quarter = _arctangent(1, 1, TURN_FRACTION + guard)
    turns = []
    for i in range(MAX_HALF_TURN * _TURN_STEPS + 2):
        if i <= _TURN_STEPS:
            half = _arctangent(i, _TURN_STEPS, TURN_FRACTION + guard)
        else:
            half = 2 * quarter - _arctangent(_TURN_STEPS, i, TURN_FRACTION + guard)
        turns.append(2 * half >> guard)
    return tuple(turns)


def _arctangent(opposite: int, adjacent: int, bits: int) -> int:
    """Return the arc tangent of a ratio of at most 1 with ``bits`` fraction bits."""
    square = opposite**2 + adjacent**2
    term = (opposite * adjacent << bits) // square
    total, n = 0, 0
    while term:
        total += term
        n += 1
        term = term * 2 * n * opposite**2 // ((2 * n + 1) * square)
    return total
