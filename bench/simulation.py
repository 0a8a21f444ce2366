"""Cycles per second of the simulated board, and generations per second of the software model."""

from __future__ import annotations

import random
import time

from bench.report import Options, Report
from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codes import LinkMode
from pathgene.host.device.boards import open_board
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link
from pathgene.sim.board.scheme import start_simulated
from pathgene.sim.model.core import PaperCore


_GENERATIONS, _CORE_GENERATIONS = 60, 2000


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
    report.further = [_model_core()]
    return report


def _model_core() -> Report:
    """Run the model's core without the link, on paths of a planner's lengths and on long ones."""
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
        for generation in range(_CORE_GENERATIONS):
            core.run(orders[generation % 64])
        report.rows.append((title, _CORE_GENERATIONS / (time.process_time() - started)))
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
