"""The exported scorer in Verilator, compared with the compiled model on very many paths."""

from pathlib import Path

import numpy as np
import pytest

from pathgene.hdl.layouts import point_layout
from pathgene.hdl.planner.layouts import problem_layout
from pathgene.hdl.planner.scorer.scorer import chord_record_layout, score_layout
from pathgene.sim.exported import exported_verilog
from pathgene.sim.harness.program import VerilatedProgram
from pathgene.sim.model.planner.evaluator_cycles import ScorerCycles, freed
from tests.support.planner.cases import LARGE, SMALL, USUAL, words
from tests.support.planner.scorer_cases import (
    compiled_score,
    drawn_paths,
    drawn_problem,
    problem_fields,
)


pytestmark = [pytest.mark.cosim, pytest.mark.ci]

PATHS_OF_A_PROBLEM = 50


def order(config, problem, paths, stall):
    """Return the numbers that have paths scored."""
    layout = point_layout(config.coordinate_bits, config.altitude_bits)
    points = [
        layout.const({"x": x, "y": y, "altitude": altitude, "last": i == len(path) - 1}).as_bits()
        for path in paths
        for i, (x, y, altitude) in enumerate(path)
    ]
    fields = words(problem_layout(config).const(problem_fields(problem)))
    segments = sum(sizes_of(problem, paths)) - len(paths)
    return [1, stall, len(paths), segments, len(fields), *fields, len(points), *points]


def sizes_of(problem, paths):
    """Return the points of each path, entry and exit included."""
    return [len(path) + problem.has_entry + problem.has_exit for path in paths]


def answer(config, chip, sizes):
    """Return launches, scores and chords of the paths, with their cycles."""
    launches = chip.receive(len(sizes)).tolist()
    scores = chip.receive(2 * len(sizes)).reshape(-1, 2).tolist()
    records = chip.receive(3 * (sum(sizes) - len(sizes))).reshape(-1, 3).tolist()
    score = score_layout()
    chord = chord_record_layout(config.coordinate_bits, config.altitude_bits)
    found = []
    for bits, cycle in scores:
        each = score.from_bits(bits)
        found.append((cycle, bool(each.infeasible), each.value))
    chords = []
    for cycle, low, high in records:
        each = chord.from_bits(low | high << 64)
        both = tuple((end.x, end.y, end.altitude) for end in (each.start, each.stop))
        chords.append((cycle, bool(each.last), both if each.present else None))
    return launches, found, chords


@pytest.mark.parametrize("pause", [0, 3], ids=["steady", "stalled"])
@pytest.mark.parametrize(
    ("config", "count"),
    [
        (SMALL, 1_000),
        (SMALL.replace(point_cycles=2), 1_000),
        (USUAL, 1_000),
        pytest.param(LARGE, 500, marks=pytest.mark.long),
        pytest.param(USUAL.replace(point_cycles=2), 100_000, marks=pytest.mark.long),
        pytest.param(SMALL, 100_000, marks=pytest.mark.long),
        pytest.param(USUAL, 100_000, marks=pytest.mark.long),
        pytest.param(LARGE, 20_000, marks=pytest.mark.long),
    ],
    ids=[
        "small",
        "small-two-cycles",
        "usual",
        "large",
        "long-two-cycles",
        "long-small",
        "long-usual",
        "long-large",
    ],
)
def test_matches_the_model_on_many_paths(config, count, pause):
    rng = np.random.default_rng(count + pause)
    cycles = ScorerCycles.of(config)
    feasible = chords_seen = 0
    main = Path(__file__).with_name("scorer_soak.cpp")
    with VerilatedProgram(exported_verilog("scorer", config), "scorer", main) as chip:
        for _ in range(count // PATHS_OF_A_PROBLEM):
            problem = drawn_problem(config, rng)
            paths = drawn_paths(config, rng, problem, PATHS_OF_A_PROBLEM)
            chip.send(order(config, problem, paths, pause))
            expected = [compiled_score(config, problem, path) for path in paths]
            sizes = sizes_of(problem, paths)
            launches, scores, chords = answer(config, chip, sizes)
            assert [each[1:] for each in scores] == [score for score, _ in expected]
            assert [each[1:] for each in chords] == [
                (i == len(each) - 1, chord) for _, each in expected for i, chord in enumerate(each)
            ]
            if not pause:
                begun = list(zip(launches, sizes, strict=True))
                assert launches[1:] == [freed(*each, config.point_cycles) for each in begun[:-1]]
                assert [each[0] for each in scores] == [cycles.scored(*each) for each in begun]
                assert [each[0] for each in chords] == [
                    cycles.sent(start, segment)
                    for start, size in begun
                    for segment in range(size - 1)
                ]
            feasible += sum(not infeasible for _, infeasible, _ in scores)
            chords_seen += sum(chord is not None for *_, chord in chords)
    # Every kind of path is among them.
    assert count // 20 < feasible < count * 9 // 10
    assert chords_seen > count // 10
