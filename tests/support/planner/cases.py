"""Random maps, problems and paths for the planner core, and segments for its walker."""

import dataclasses
import itertools

import numpy as np

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    BASE_BITS,
    BEND_BITS,
    DRAG_FRACTION,
    EDGE_BITS,
    EDGES,
    FUEL_BITS,
    POSITION_FRACTION,
    RADIUS_BITS,
    RISE_BITS,
    SCALE_FRACTION,
    SLOPE_BITS,
    NoFlyShape,
    ProblemRecord,
)


#: A small chip, a chip of the default sizes, and the largest.
SMALL = Config(
    population=8, children=4, elites=2, survivors=2, perturbs=1, inserts=1, deletes=1,
    max_waypoints=5, map_size=32, coarse_factor=4, altitude_bits=8, lanes=4, core="planner",
)  # fmt: skip
USUAL = Config(core="planner")
LARGE = Config(map_size=4096, altitude_bits=16, max_waypoints=64, core="planner")


def ground(config, rng, *, blocked=0.02):
    """Rolling hills up to half of all altitudes, with blocked corners."""
    size = config.map_size
    x, y = np.meshgrid(np.arange(size), np.arange(size))
    hills = sum(
        np.sin(x * rng.uniform(0, 12 / size) + y * rng.uniform(0, 12 / size) + rng.uniform(0, 6))
        for _ in range(4)
    )
    heights = ((hills + 4) / 8 * (config.blocked_altitude // 2)).astype(np.uint16)
    heights[rng.random(heights.shape) < blocked] = config.blocked_altitude
    heights[-1], heights[:, -1] = config.blocked_altitude, config.blocked_altitude
    return heights


def record(config, rng, **changes):
    """A problem whose aircraft climbs and turns well enough to fly over such hills."""
    size, top = config.map_size, config.blocked_altitude
    far = (size - 2) << POSITION_FRACTION
    values = {
        "start_x": int(rng.integers(far // 4)),
        "start_y": int(rng.integers(far // 4)),
        "start_altitude": int(rng.integers(8 * top, 12 * top)),
        "goal_x": far - int(rng.integers(far // 4)),
        "goal_y": far - int(rng.integers(far // 4)),
        "goal_altitude": int(rng.integers(8 * top, 12 * top)),
        "x_limit": size - 2,
        "y_limit": size - 2,
        "altitude_limit": top - 1,
        "x_scale": int(rng.integers(1 << SCALE_FRACTION - 1, (1 << SCALE_FRACTION) + 1)),
        "y_scale": 1 << SCALE_FRACTION,
        "rise": 12_000,
        "climb": 12_000 * top // 4095,
        "descent": 20_000 * top // 4095,
        "radius": int(rng.integers(1, 1 << POSITION_FRACTION + 2)),
        "base": int(rng.integers(-top, 100 * top)),
        "drag": 5_201,
        "fuel": 60_294,
        "fuel_shift": 13,
        "key_shift": 10,
        "block_shift": max(config.coordinate_bits - 5, 0),
    }
    return ProblemRecord(**values | changes)


def any_record(config, rng):
    """A problem with any value in every field, often extremes."""

    def value(bits):
        kind = rng.integers(4)
        if kind < 2:
            return (0, (1 << bits) - 1)[kind]
        return int(rng.integers(1 << int(rng.integers(1, bits + 1))))

    position = config.coordinate_bits + POSITION_FRACTION
    altitude = config.altitude_bits + 4
    return record(
        config,
        rng,
        start_x=value(position),
        start_y=value(position),
        start_altitude=value(altitude),
        goal_x=value(position),
        goal_y=value(position),
        goal_altitude=value(altitude),
        x_scale=int(rng.choice([1, 1 << SCALE_FRACTION])),
        rise=value(RISE_BITS),
        climb=value(SLOPE_BITS),
        descent=value(SLOPE_BITS),
        radius=value(RADIUS_BITS),
        base=value(BASE_BITS - 1) * int(rng.choice([-1, 1])),
        drag=value(DRAG_FRACTION),
        fuel=value(FUEL_BITS),
        fuel_shift=value(5),
        key_shift=value(6),
    )


def headed(config, rng, problem):
    """``problem`` with an entry or an exit in three of four cases, anywhere or a few cells away."""
    far = (config.map_size << POSITION_FRACTION) - 1
    top = config.blocked_altitude << ALTITUDE_FRACTION
    values = {}
    for point, end in (("entry", "start"), ("exit", "goal")):
        values[f"has_{point}"] = int(rng.integers(2))
        span = int(rng.choice([6 << POSITION_FRACTION, far]))
        for axis, most in (("x", far), ("y", far), ("altitude", top)):
            value = getattr(problem, f"{end}_{axis}") + int(rng.integers(-span, span + 1))
            values[f"{point}_{axis}"] = min(max(value, 0), most)
    return dataclasses.replace(problem, **values)


def shape(config, rng, *, span=None):
    """A box, disc or polygon anywhere, whose edges cross its box of at most ``span`` corners."""
    (x0, x1), (y0, y1) = np.sort(rng.integers(config.map_size, size=(2, 2))).tolist()
    if span is not None:
        x1, y1 = min(x1, x0 + span - 1), min(y1, y0 + span - 1)
    bend = [0, 0] if rng.integers(2) else rng.integers(1 << BEND_BITS, size=2).tolist()
    edges = []
    for i in range(rng.integers(EDGES + 1)):
        most = (1 << EDGE_BITS - 1) >> int(rng.integers(EDGE_BITS))
        east, north = rng.integers(-most, most, size=2).tolist()
        # 0 or more at some corner of the box.
        u, v = int(rng.integers(x1 - x0 + 1)), int(rng.integers(y1 - y0 + 1))
        at = -east * u - north * v + (bend[0] * u * u + bend[1] * v * v) * (i == 0)
        half = 1 << config.coordinate_bits + EDGE_BITS
        edges.append((min(max(at, -half), half - 1), east, north))
    # No edge, no bend.
    bend = bend if edges else [0, 0]
    return NoFlyShape(
        first_x=x0,
        first_y=y0,
        last_x=x1,
        last_y=y1,
        edges=tuple(edges),
        bend_x=bend[0],
        bend_y=bend[1],
    )


def path(config, rng, *, waypoints=None):
    """Points of a path with any corners and steps, within a window of any size."""
    count = int(rng.integers(2, config.max_waypoints + 1)) if waypoints is None else waypoints
    span = int(rng.choice([2, 10, config.map_size]))
    span = min(span, config.map_size)
    corner = rng.integers(config.map_size - span + 1, size=2)
    corners = corner + rng.integers(span, size=(count + 2, 2))
    steps = rng.integers(config.blocked_altitude, size=(count + 2, 1))
    return [tuple(point) for point in np.hstack((corners, steps)).tolist()]


def rows(points, margins=None):
    """Points in the form of the compiled kernels: rows x, y, step, margin."""
    margins = [0] * len(points) if margins is None else margins
    return np.array([(*point, m) for point, m in zip(points, margins, strict=True)], dtype=np.int64)


def corner(point):
    """A point as the fields of a signal."""
    return dict(zip(("x", "y", "altitude"), point, strict=True))


def words(payload):
    """Return a constant as 32-bit words, the lowest first."""
    bits, size = payload.as_bits(), payload.shape().size
    return [bits >> 32 * i & 0xFFFFFFFF for i in range(-(-size // 32))]


def any_point(config, rng):
    """Any corner and altitude, often the lowest or the highest."""
    top = config.blocked_altitude
    altitude = rng.integers(top + 1) if rng.random() < 0.7 else rng.choice([0, 1, top - 1, top])
    return (*(int(c) for c in rng.integers(config.map_size, size=2)), int(altitude))


def segments_of(points, chords, first):
    """Segments of a path in walking order: ends and marks; each point has a chord or None."""
    ends = []
    for i, (point, chord) in enumerate(zip(points, chords, strict=True)):
        ends += [((points[i - 1], point), False)] if i else []
        ends += [(chord, True)] if chord is not None else []
    return [
        (*each, {"begins": i == 0, "last": i == len(ends) - 1, "chord": is_chord, "first": first})
        for i, (each, is_chord) in enumerate(ends)
    ]


def heights_of(config, rng, *, blocked=0.1):
    """Ground of any altitudes, with blocked corners."""
    shape = (config.map_size, config.map_size)
    heights = rng.integers(config.blocked_altitude, size=shape)
    heights[rng.random(shape) < blocked] = config.blocked_altitude
    return heights.astype(np.uint16)


async def upload(ctx, dut, heights):
    """Write a whole map, one corner per cycle, and wait until it is written."""
    ctx.set(dut.writes.valid, 1)
    for y, x in itertools.product(*(range(size) for size in heights.shape)):
        ctx.set(dut.writes.p, {"x": x, "y": y, "altitude": int(heights[y, x]), "last": 0})
        await ctx.tick()
    ctx.set(dut.writes.valid, 0)
    await ctx.tick().repeat(3)
