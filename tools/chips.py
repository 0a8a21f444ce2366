"""The small chip of tests, mutation testing and documents; URLs of chips."""

from __future__ import annotations

import dataclasses
from urllib.parse import urlencode

from pathgene.hdl.config import CheckerBuild, Config


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


def board_url(scheme: str, config: Config, **options: object) -> str:
    """Return the URL of ``scheme`` (``model`` or ``sim``) for a chip of ``config``."""
    fields = {
        field.name: int(value) if isinstance(value := getattr(config, field.name), bool) else value
        for field in dataclasses.fields(Config)
        if field.name == "clocks_per_bit" or getattr(config, field.name) != field.default
    }
    return f"{scheme}:?{urlencode(fields | options)}"
