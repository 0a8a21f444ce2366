"""The exported evaluator of paths in Verilator: keys, margins and cycles of many paths."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from pathgene.hdl.layouts import point_layout
from pathgene.hdl.planner.layouts import head_layout, member_layout, problem_layout
from pathgene.hdl.planner.path_evaluator import PathEvaluator
from pathgene.hdl.planner.population_memory import decided_layout, margin_layout
from pathgene.hdl.verilog import convert
from pathgene.sim.exported import cached_verilog
from pathgene.sim.harness.program import VerilatedProgram
from tests.support.planner.cases import SMALL, USUAL, corner, ground, words
from tests.support.planner.evaluator_bench import Findings
from tests.support.planner.evaluator_cases import (
    check_cycles,
    check_findings,
    drawn_evaluator,
    drawn_paths,
    outcomes,
)
from tests.support.planner.scorer_cases import problem_fields


pytestmark = pytest.mark.cosim

SLOTS = 54


class Layouts:
    """Layouts of the payloads of one configuration."""

    def __init__(self, config):
        sizes = (config.coordinate_bits, config.altitude_bits)
        slot_bits = (SLOTS - 1).bit_length()
        self.problem = problem_layout(config)
        self.point = point_layout(*sizes)
        self.head = head_layout(slot_bits)
        self.member = member_layout(slot_bits, config.length_bits)
        self.decided = decided_layout(SLOTS)
        self.margin = margin_layout(SLOTS, config.max_waypoints, config.altitude_bits)


def verilated(config, rows):
    def export():
        return convert(PathEvaluator(config, SLOTS, rows), "path_evaluator")

    text = cached_verilog(export, "path_evaluator", repr(config), str(rows))
    return VerilatedProgram(text, "path_evaluator", Path(__file__).with_name("path_evaluator.cpp"))


def orders(layouts, evaluator, paths, stall):
    """Return the numbers that upload ground and problem, and have the paths evaluated."""
    heights = evaluator.ground
    cells = [
        layouts.point.const(corner((x, y, int(heights[y, x])))).as_bits()
        for y, x in itertools.product(*(range(size) for size in heights.shape))
    ]
    problem = words(layouts.problem.const(problem_fields(evaluator.record)))
    heads, points = [], []
    for path in paths:
        head = layouts.head.const(path.head).as_bits()
        heads += [head, path.gap, len(path.points)]
        points += [
            layouts.point.const(corner(point) | {"last": i == len(path.points) - 1}).as_bits()
            for i, point in enumerate(path.points)
        ]
    return [
        *(1, len(cells), *cells),
        *(2, len(problem), *problem),
        *(3, stall, len(paths), *heads, len(points), *points),
    ]


def findings(layouts, chip, count):
    """Return the answer to the evaluation of ``count`` paths."""
    each = chip.receive(4 * count).reshape(-1, 4).tolist()
    walk, margins = chip.receive(2).tolist()
    decided = chip.receive(2 * count).reshape(-1, 2).tolist()
    written = chip.receive(2 * margins).reshape(-1, 2).tolist()
    found = Findings(walk=walk)
    for bits, offered, goal, keyed in each:
        member = layouts.member.from_bits(bits)
        found.members.append((member.key, member.slot, member.length))
        found.offered.append(offered)
        found.goals.append(goal)
        found.keyed.append(keyed)
    for bits, cycle in decided:
        decision = layouts.decided.from_bits(bits)
        found.decisions.append((decision.slot, decision.walked))
        found.decided.append(cycle)
    for bits, cycle in written:
        margin = layouts.margin.from_bits(bits)
        found.margins.append((margin.place.slot, margin.place.index, margin.margin))
        found.written.append(cycle)
    return found


@pytest.mark.parametrize("count", [100, pytest.param(20_000, marks=pytest.mark.long)])
@pytest.mark.parametrize(
    ("config", "rows", "repeat"),
    [
        pytest.param(SMALL.replace(memory_latency=1), 64, 0.8, marks=pytest.mark.ci),
        pytest.param(SMALL.replace(lanes=1), 0, 0.3, marks=pytest.mark.long),
        pytest.param(SMALL.replace(point_cycles=2), 64, 0.8, marks=pytest.mark.long),
        # Their builds take over a minute each.
        pytest.param(USUAL, 512, 0.9, marks=pytest.mark.long),
        pytest.param(USUAL.replace(lanes=16), 0, 0.9, marks=pytest.mark.long),
    ],
    ids=["small", "one lane", "two cycles", "usual", "no memo"],
)
def test_keys_margins_and_cycles(config, rows, repeat, count):
    """All match with and without entry and exit, back-pressure and long walks."""
    rng = np.random.default_rng([rows, config.lanes])
    layouts = Layouts(config)
    late = walked = 0
    with verilated(config, rows) as chip:
        for heading, stall in itertools.product(range(4), (0, 3)):
            terrain = ground(config, rng, blocked=0.0005)
            evaluator = drawn_evaluator(config, rng, terrain, heading, radius=200)
            paths = drawn_paths(evaluator, rng, count, SLOTS, repeat=repeat, gaps=heading % 2 == 0)
            chip.send(orders(layouts, evaluator, paths, stall))
            expected = outcomes(evaluator, rows, paths)
            found = findings(layouts, chip, len(paths))
            ahead = check_findings(found, expected)
            assert (ahead >= 3) if stall else (ahead == 3)
            walked += sum(each.costs is not None for each in expected)
            if not stall:
                late += check_cycles(evaluator, paths, found, expected)
    assert 2 * count < walked < 7 * count
    assert 10 < late < 4 * count
