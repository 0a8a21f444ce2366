"""Generations per second of the software model's core, without the link."""

from __future__ import annotations

import random
import time

from bench.report import Options, Report
from pathgene.hdl.config import Config
from pathgene.sim.model.core import PaperCore


__all__ = ["run"]

_GENERATIONS = 2000


def run(options: Options) -> Report:
    """Run the core on paths of a planner's lengths and on long paths."""
    report = Report("Software model, one core", ("paths", "generations per second"))
    config = Config()
    for title, lengths in (("of 2 to 7 waypoints", (2, 7)), ("of 16 waypoints", (16, 16))):
        rng = random.Random(1)
        core = PaperCore(config)
        core.start(1, core.limits)
        core.paths = [
            [rng.getrandbits(config.waypoint_bits) for _ in range(rng.randint(*lengths))]
            for _ in range(config.population)
        ]
        orders = [rng.sample(range(config.population), config.population) for _ in range(64)]
        started = time.process_time()
        for generation in range(_GENERATIONS):
            core.run(orders[generation % 64])
        report.rows.append((title, _GENERATIONS / (time.process_time() - started)))
    return report
