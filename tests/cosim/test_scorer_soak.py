"""The exported scorer in Verilator against the compiled model, on very many paths."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

from hdl.layouts import point_layout
from hdl.planner.layouts import problem_layout
from hdl.planner.scorer.chord_queue import chord_layout
from hdl.planner.scorer.scorer import score_layout
from sim.cache import BuildCache, build_root
from sim.exported import exported_verilog
from sim.verilator import build_verilator
from tests.planner_cases import LARGE, SMALL, USUAL
from tests.scorer_cases import compiled_score, drawn_paths, drawn_problem, problem_fields


pytestmark = [pytest.mark.cosim, pytest.mark.ci]

PATHS_OF_A_PROBLEM = 50


def words(value, count):
    """Return an integer as 32-bit words, the lowest first."""
    return [value >> 32 * i & 0xFFFFFFFF for i in range(count)]


def batch(config, problem, paths, gives_up, pause):
    """Return a problem and its paths as the program takes them."""
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
    head = [gives_up, pause, len(paths), len(points) // 2]
    return np.array([*head, *fields, *points], dtype=np.uint32).tobytes()


def unpack(config, raw, paths):
    """Return cycles, scores and chords of a batch, and the words left."""
    waypoints = sum(len(path) - 2 for path in paths)
    cycles, raw = int(raw[0]), raw[1:]
    scores, raw = raw[: 2 * len(paths)].reshape(-1, 2), raw[2 * len(paths) :]
    ends, raw = raw[: 3 * waypoints].reshape(-1, 3).astype(object), raw[3 * waypoints :]
    score, chord = score_layout(), chord_layout(config.coordinate_bits, config.altitude_bits)
    found = []
    for bits, _ in scores.tolist():
        each = score.from_bits(bits)
        found.append((bool(each.infeasible), bool(each.unlimited), each.value))
    chords = []
    for low, middle, high in ends.tolist():
        each = chord.from_bits(low | middle << 32 | high << 64)
        both = tuple((end.x, end.y, end.altitude) for end in each.ends)
        chords.append(both if each.exists else None)
    return cycles, found, chords, raw


@pytest.mark.parametrize("pause", [0, 3], ids=["steady", "stalled"])
@pytest.mark.parametrize(
    ("config", "count"),
    [
        (SMALL, 3_000),
        (USUAL, 3_000),
        (LARGE, 500),
        pytest.param(SMALL, 100_000, marks=pytest.mark.long),
        pytest.param(USUAL, 100_000, marks=pytest.mark.long),
        pytest.param(LARGE, 20_000, marks=pytest.mark.long),
    ],
    ids=["small", "usual", "large", "long-small", "long-usual", "long-large"],
)
def test_matches_the_model_on_many_paths(config, count, pause):
    rng = np.random.default_rng(count + pause)
    batches = []
    for _ in range(count // PATHS_OF_A_PROBLEM):
        problem = drawn_problem(config, rng)
        paths = drawn_paths(config, rng, problem, PATHS_OF_A_PROBLEM)
        batches.append((problem, paths, bool(rng.integers(2))))
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
    for problem, paths, gives_up in batches:
        expected = [compiled_score(config, problem, path, gives_up) for path in paths]
        _, scores, chords, raw = unpack(config, raw, paths)
        assert scores == [score for score, _ in expected]
        assert chords == [chord for _, each in expected for chord in each]
        feasible += sum(not infeasible for infeasible, _, _ in scores)
        chords_seen += sum(chord is not None for chord in chords)
    assert raw.size == 0
    # Every kind of path is among them.
    assert count // 10 < feasible < count * 9 // 10
    assert chords_seen > count // 10
