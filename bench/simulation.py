"""Cycles per second of the simulated board, with the whole chip active."""

from __future__ import annotations

import random
import time

from bench.report import Options, Report
from pathgene.hdl.protocol import LinkMode
from pathgene.host.device.boards import open_board
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link
from pathgene.sim.board.scheme import start_simulated


__all__ = ["run"]

_GENERATIONS = 60


def run(options: Options) -> Report:
    """Run generations on the simulated board and on the model."""
    report = Report(
        "Simulated board",
        ("board", "cycles per second", "generations per second"),
        notes=["Rank mode over the whole link, paths of 2 to 7 waypoints."],
    )
    with start_simulated("sim:") as board, Chip(Link(board.open(), timeout_s=20)) as chip:
        before = board.cycles()
        seconds = _run(chip)
        report.rows.append(("sim:", (board.cycles() - before) / seconds, _GENERATIONS / seconds))
    with open_board("model:") as chip:
        report.rows.append(("model:", "-", _GENERATIONS / _run(chip)))
    return report


def _run(chip: Chip) -> float:
    rng = random.Random(1)
    config = chip.config
    highest = config.map_size - 1
    chip.start(1, (highest, highest, config.blocked_altitude - 1))
    chip.load(
        [
            [rng.getrandbits(config.waypoint_bits) for _ in range(rng.randint(2, 7))]
            for _ in range(config.population)
        ]
    )
    order = list(range(config.population))
    started = time.perf_counter()
    for _ in range(_GENERATIONS):
        rng.shuffle(order)
        chip.step(order, LinkMode.RANK)
    return time.perf_counter() - started
