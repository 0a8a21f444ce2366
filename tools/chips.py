"""The small chip of tests, mutation testing and documents."""

from __future__ import annotations

from hdl.config import CheckerBuild, Config


__all__ = ["SMALL"]

#: A chip that simulators build and run in seconds, with odd sizes, short messages, and a receive
#: buffer that fills soon.
SMALL = Config(
    population=8,
    children=4,
    survivors=2,
    inserts=1,
    deletes=1,
    max_waypoints=5,
    map_size=16,
    coarse_factor=4,
    altitude_bits=4,
    clocks_per_bit=4,
    receive_buffer=256,
    checker=CheckerBuild.NONE,
)
