"""The exported scorer in Verilator, compared with the compiled model on very many paths."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

from pathgene.hdl.layouts import point_layout
from pathgene.hdl.planner.layouts import problem_layout
from pathgene.hdl.planner.scorer.scorer import chord_record_layout, score_layout
from pathgene.sim.cache import BuildCache, build_root
from pathgene.sim.exported import exported_verilog
from pathgene.sim.model.planner.evaluator_cycles import ScorerCycles, freed
from pathgene.sim.verilator import build_verilator
from tests.support.planner.cases import LARGE, SMALL, USUAL
from tests.support.planner.scorer_cases import (
    compiled_score,
    drawn_paths,
    drawn_problem,
    problem_fields,
)


pytestmark = [pytest.mark.cosim, pytest.mark.ci]

PATHS_OF_A_PROBLEM = 50


def words(value, count):
    """Return an integer as 32-bit words, the lowest first."""
    return [value >> 32 * i & 0xFFFFFFFF for i in range(count)]


def batch(config, problem, paths, pause):
    """Return a problem and its paths in the form that the program reads."""
    layout = point_layout(config.coordinate_bits, config.altitude_bits)
    record = problem_layout(config)
    points = [
        word
        for path in paths
        for i, (x, y, altitude) in enumerate(path)
        for word in words(
            layout.const(
                {"x": x, "y": y, "altitude": altitude, "last": i == len(path) - 1}
            ).as_bits(),
            2,
        )
    ]
    fields = words(record.const(problem_fields(problem)).as_bits(), -(-record.size // 32))
    head = [pause, len(paths), len(points) // 2, sum(sizes_of(problem, paths)) - len(paths)]
    return np.array([*head, *fields, *points], dtype=np.uint32).tobytes()


def sizes_of(problem, paths):
    """Return the points of each path, entry and exit included."""
    return [len(path) + problem.has_entry + problem.has_exit for path in paths]


def unpack(config, raw, sizes):
    """Return launches, scores and chords of a batch, with their cycles, and the remaining words."""
    launches, raw = raw[: len(sizes)].tolist(), raw[len(sizes) :]
    scores, raw = raw[: 2 * len(sizes)].reshape(-1, 2), raw[2 * len(sizes) :]
    segments = sum(sizes) - len(sizes)
    records, raw = raw[: 4 * segments].reshape(-1, 4).astype(object), raw[4 * segments :]
    score = score_layout()
    chord = chord_record_layout(config.coordinate_bits, config.altitude_bits)
    found = []
    for bits, cycle in scores.tolist():
        each = score.from_bits(bits)
        found.append((cycle, bool(each.infeasible), each.value))
    chords = []
    for cycle, low, middle, high in records.tolist():
        each = chord.from_bits(low | middle << 32 | high << 64)
        both = tuple((end.x, end.y, end.altitude) for end in (each.start, each.stop))
        chords.append((cycle, bool(each.last), both if each.present else None))
    return launches, found, chords, raw


@pytest.mark.parametrize("pause", [0, 3], ids=["steady", "stalled"])
@pytest.mark.parametrize(
    ("config", "count"),
    [
        (SMALL, 1_000),
        (USUAL, 1_000),
        pytest.param(LARGE, 500, marks=pytest.mark.long),
        pytest.param(SMALL, 100_000, marks=pytest.mark.long),
        pytest.param(USUAL, 100_000, marks=pytest.mark.long),
        pytest.param(LARGE, 20_000, marks=pytest.mark.long),
    ],
    ids=["small", "usual", "large", "long-small", "long-usual", "long-large"],
)
def test_matches_the_model_on_many_paths(config, count, pause):
    rng = np.random.default_rng(count + pause)
    cycles = ScorerCycles.of(config)
    batches = []
    for _ in range(count // PATHS_OF_A_PROBLEM):
        problem = drawn_problem(config, rng)
        batches.append((problem, drawn_paths(config, rng, problem, PATHS_OF_A_PROBLEM)))
    program = build_verilator(
        BuildCache(build_root() / "sim"),
        exported_verilog("scorer", config),
        "scorer",
        main=Path(__file__).with_name("scorer_soak.cpp"),
    )
    data = b"".join(batch(config, *each, pause) for each in batches)
    done = subprocess.run([program], input=data, stdout=subprocess.PIPE, check=True)
    raw = np.frombuffer(done.stdout, dtype=np.uint32)

    feasible = chords_seen = 0
    for problem, paths in batches:
        expected = [compiled_score(config, problem, path) for path in paths]
        sizes = sizes_of(problem, paths)
        launches, scores, chords, raw = unpack(config, raw, sizes)
        assert [each[1:] for each in scores] == [score for score, _ in expected]
        assert [each[1:] for each in chords] == [
            (i == len(each) - 1, chord) for _, each in expected for i, chord in enumerate(each)
        ]
        if not pause:
            begun = list(zip(launches, sizes, strict=True))
            assert launches[1:] == [freed(*each) for each in begun[:-1]]
            assert [each[0] for each in scores] == [cycles.scored(*each) for each in begun]
            assert [each[0] for each in chords] == [
                cycles.sent(start, segment) for start, size in begun for segment in range(size - 1)
            ]
        feasible += sum(not infeasible for _, infeasible, _ in scores)
        chords_seen += sum(chord is not None for *_, chord in chords)
    assert raw.size == 0
    # Every kind of path is among them.
    assert count // 20 < feasible < count * 9 // 10
    assert chords_seen > count // 10
