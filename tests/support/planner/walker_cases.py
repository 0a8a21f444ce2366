"""Segments, paths and drivers for the planner core's walker."""

import itertools

import numpy as np


def corner(point):
    """A point as the fields of a signal."""
    return dict(zip(("x", "y", "altitude"), point, strict=True))


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
