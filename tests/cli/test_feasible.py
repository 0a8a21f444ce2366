"""``pathgene feasible``: the checker's verdict on files of cells and altitude steps."""

import json
import re
import sys

import numpy as np
import pytest

import pathgene.host.cli.feasible
import pathgene.host.device.boards
import pathgene.host.device.chip_map
from bench.feasibility import TESTING_TRAJECTORY, canyon_map
from pathgene.host.cli import main
from pathgene.host.device.checker_modes import MODES
from pathgene.host.device.chip_map import padded_map
from pathgene.sim.model.checker import TerrainModel, check_path
from pathgene.sim.model.checker_cycles import batch_cycles
from tests.support.gateware.chips import CHECKERS
from tools.chips import board_url


# --- Files ---------------------------------------------------------------------------------------


def write_path(file, points):
    file.write_text("x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in points))
    return file


@pytest.fixture(scope="module")
def canyon(tmp_path_factory):
    """Options of the testing trajectory over its canyon."""
    folder = tmp_path_factory.mktemp("canyon")
    np.save(folder / "canyon.npy", canyon_map())
    path = write_path(folder / "path.csv", TESTING_TRAJECTORY)
    return "--map", folder / "canyon.npy", "--path", path


@pytest.fixture
def level(tmp_path):
    """Options of a path over 40 x 30 level cells at 100, with one blocked cell and one peak."""
    heights = np.full((30, 40), 100, dtype=np.int32)
    heights[5, 10], heights[5, 20] = 4095, 900
    np.save(tmp_path / "level.npy", heights)
    path = write_path(tmp_path / "path.csv", [(2, 5, 500), (25, 5, 500), (25, 25, 500)])
    return "--map", tmp_path / "level.npy", "--path", path


def feasible(capsys, *arguments):
    """Return the output of the command, the same object with and without ``--json``.

    A collision is exit status 1 with a sentence.
    """
    command = ["feasible", *map(str, arguments)]
    status = main(command)
    line, said = capsys.readouterr()
    assert main([*command, "--json"]) == status
    printed = json.loads(capsys.readouterr().out)
    assert status == int(printed["collision"])
    if printed["collision"]:
        x, y = printed["cell"]
        segment = printed["segment"]
        assert said == f"pathgene: The path collides on segment {segment}, in cell ({x}, {y}).\n"
    else:
        assert said == ""
    assert line.count("\n") == 1
    assert json.loads(line) == printed
    return printed


def refused(capsys, *arguments):
    """Return the sentence of a command that must fail with status 2."""
    assert main(["feasible", *map(str, arguments)]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.startswith("pathgene: ")
    assert output.err.count("\n") == 1
    return output.err.removeprefix("pathgene: ").rstrip("\n")


# --- Verdicts ------------------------------------------------------------------------------------

KEYS = ["collision", "over", "segment", "cell", "map", "cells", "reads", "cycles"]


def test_the_testing_trajectory_in_two_tiers(canyon, capsys):
    printed = feasible(capsys, *canyon)
    assert list(printed) == KEYS
    assert printed["collision"] is True
    assert printed["over"] is False
    assert (printed["segment"], printed["cell"], printed["map"]) == (2, [10, 10], "coarse")
    assert printed["cells"] == 55 + 100 + 6
    assert printed["cycles"] <= 171
    assert feasible(capsys, *canyon, "--mode", "two-tier") == printed


@pytest.mark.parametrize("mode", ["detailed", "parallel"])
def test_the_testing_trajectory_in_detail(canyon, capsys, mode):
    printed = feasible(capsys, *canyon, "--mode", mode)
    assert list(printed) == KEYS
    assert printed["collision"] is False
    assert printed["over"] is True
    assert [printed[name] for name in ("segment", "cell", "map")] == [None] * 3
    assert printed["cells"] == 55 + 100 + 94


def test_modes_differ_only_in_their_cycles(canyon, capsys):
    """One cell per cycle is compared with eight; the two-tier mode stops at the coarse map."""
    cycles = {mode: feasible(capsys, *canyon, "--mode", mode)["cycles"] for mode in MODES}
    assert cycles["parallel"] <= 44
    assert cycles["parallel"] < cycles["two-tier"] <= 171 < cycles["detailed"]
    assert feasible(capsys, *canyon, "--board", "model:?checker=parallel&lanes=16")["cycles"] <= 30


def test_counts_of_every_segment(level, capsys):
    """The third of the path outside the given map counts as no-fly cells."""
    printed = feasible(capsys, *level, "--count", "--mode", "detailed")
    assert list(printed) == [*KEYS, "colliding"]
    assert (printed["segment"], printed["cell"], printed["map"]) == (0, [10, 5], "detailed")
    assert printed["cells"] == 9
    assert printed["colliding"] == [[1, 1], [0, 0]]
    assert printed["reads"] >= 24 + 21

    stopped = feasible(capsys, *level, "--mode", "detailed")
    assert [stopped[key] for key in KEYS[:6]] == [printed[key] for key in KEYS[:6]]
    assert stopped["reads"] < printed["reads"]


def test_pads_a_smaller_map_with_no_fly_cells(level, tmp_path, capsys):
    path = write_path(tmp_path / "long.csv", [(0, 29, 200), (0, 31, 200), (41, 31, 200)])
    printed = feasible(capsys, *level[:3], path, "--mode", "parallel", "--count")
    assert (printed["segment"], printed["cell"], printed["cells"]) == (0, [0, 30], 2)
    assert printed["colliding"] == [[0, 2], [0, 42]]


#: Small chips, which other tests simulate as well.
SMALL = {**CHECKERS, "detailed": CHECKERS["parallel"].replace(lanes=1)}


def small_cases(folder, cases):
    """Yield the options, map and path of random small jobs."""
    rng = np.random.default_rng(3)
    edge, top = SMALL["detailed"].map_size, SMALL["detailed"].blocked_altitude
    for _ in range(cases):
        heights = rng.integers(0, 5, rng.integers(edge // 2, edge + 1, 2))
        heights[rng.random(heights.shape) < 0.01] = top
        np.save(folder / "map.npy", heights)
        points = rng.integers((0, 0, 2), (*heights.shape[::-1], top), (rng.integers(2, 8), 3))
        path = [tuple(map(int, point)) for point in points]
        file = write_path(folder / "path.csv", path)
        yield ("--map", folder / "map.npy", "--path", file, "--count"), heights, path


@pytest.mark.parametrize("mode", MODES)
def test_matches_the_model(tmp_path, capsys, mode):
    """Verdicts match on small boards with their sizes in the URL."""
    config = SMALL[mode]
    board = board_url("model", config)
    collisions = 0
    for options, heights, path in small_cases(tmp_path, 12):
        terrain = TerrainModel(config)
        terrain.write(0, 0, padded_map(heights, config))
        expected = check_path(config, terrain, path, count=True)
        [(cycles, reads)] = batch_cycles(config, terrain, [path], count=True)
        printed = feasible(capsys, *options, "--board", board, "--mode", mode)
        hit = expected.collision
        counts = {segment: kinds for segment, *kinds in expected.entries}
        assert printed == {
            "collision": hit,
            "over": expected.clear,
            "segment": expected.segment if hit else None,
            "cell": [expected.x, expected.y] if hit else None,
            "map": ("coarse" if expected.coarse else "detailed") if hit else None,
            "cells": expected.cells,
            "reads": reads,
            "cycles": cycles,
            "colliding": [counts.get(segment, [0, 0]) for segment in range(len(path) - 1)],
        }
        collisions += hit
    assert 0 < collisions < 12


@pytest.mark.cosim
@pytest.mark.parametrize(
    "mode", [pytest.param(mode, marks=pytest.mark.ci if mode == "parallel" else pytest.mark.long)
             for mode in MODES],
)  # fmt: skip
def test_gateware_matches_the_model(tmp_path, capsys, mode):
    """Verdicts, cycles and reads are equal over the link."""
    for options, _, _ in small_cases(tmp_path, 2):
        printed = [
            feasible(capsys, *options, "--board", board_url(scheme, SMALL[mode]), "--mode", mode)
            for scheme in ("model", "sim")
        ]
        assert printed[0] == printed[1]


@pytest.mark.parametrize("mode", MODES)
def test_sends_only_the_part_of_the_map_that_the_path_may_reach(
    tmp_path, capsys, monkeypatch, mode
):
    """The results equal those after an upload of the whole map."""
    sent = []
    real_open, real_part = (
        pathgene.host.device.boards.open_board,
        pathgene.host.cli.feasible._walked,
    )

    def counted(url):
        chip = real_open(url)
        close = chip.close

        def end():
            sent.append(chip.link.traffic.bytes_to_board)
            close()

        monkeypatch.setattr(chip, "close", end)
        return chip

    monkeypatch.setattr(pathgene.host.device.boards, "open_board", counted)
    board = "--board", board_url("model", SMALL[mode]), "--mode", mode
    edge = SMALL[mode].map_size
    for options, _, _ in small_cases(tmp_path, 12):
        printed = feasible(capsys, *options, *board)
        monkeypatch.setattr(pathgene.host.cli.feasible, "_walked", lambda *_: (slice(0, edge),) * 2)
        assert feasible(capsys, *options, *board) == printed
        monkeypatch.setattr(pathgene.host.cli.feasible, "_walked", real_part)
    parts, wholes = sent[0::4], sent[2::4]
    assert all(part <= whole for part, whole in zip(parts, wholes, strict=True))
    assert sum(parts) < sum(wholes)


def test_a_short_path_sends_two_blocks(canyon, tmp_path, capsys, monkeypatch):
    """512 x 512 cells are 393 kB on the line; 2 blocks of 16 x 16 cells are under 1 kB."""
    sent = []
    real = pathgene.host.device.chip_map.map_frames

    def frames(*arguments):
        for payload, cells in real(*arguments):
            sent.append(len(payload))
            yield payload, cells

    monkeypatch.setattr(pathgene.host.device.chip_map, "map_frames", frames)
    path = write_path(tmp_path / "short.csv", [(3, 40, 4000), (20, 40, 4000)])
    feasible(capsys, *canyon[:3], path)
    first_of_two_runs = sent[: len(sent) // 2]
    assert 2 * 16 * 16 * 12 // 8 <= sum(first_of_two_runs) < 1000


def test_shows_the_progress_of_the_upload_on_a_terminal(level, capsys, monkeypatch):
    write_path(level[3], [(2, 5, 500), (500, 500, 500)])
    assert main(["feasible", *map(str, level)]) == 1
    assert "%" not in capsys.readouterr().err
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert main(["feasible", *map(str, level)]) == 1
    shown = [int(percent) for percent in re.findall(r"map (\d+) %", capsys.readouterr().err)]
    assert len(shown) > 2
    assert shown == sorted(shown)
    assert shown[-1] == 100


# --- Boards --------------------------------------------------------------------------------------


def test_a_real_board_limits_sizes_and_mode(level, capsys, monkeypatch):
    is_closed = []
    real = pathgene.host.device.boards.open_board
    served = "model:?checker=parallel&lanes=4&map_size=64&max_waypoints=3"

    def attached(url):
        assert url == "/dev/ttyUSB0"
        chip = real(served)
        close = chip.close
        monkeypatch.setattr(chip, "close", lambda: (is_closed.append(True), close()))
        return chip

    monkeypatch.setattr(pathgene.host.device.boards, "open_board", attached)
    board = "--board", "/dev/ttyUSB0"
    printed = feasible(capsys, *level, *board)
    assert (printed["cell"], printed["cells"]) == ([10, 5], 9)
    assert feasible(capsys, *level, *board, "--mode", "parallel") == printed
    assert refused(capsys, *level, *board, "--mode", "two-tier") == (
        "The board at '/dev/ttyUSB0' has the parallel checker of 4 lanes, which does not serve "
        "--mode two-tier; leave --mode out."
    )
    long = write_path(level[3].with_name("long.csv"), [(1, 1, 400 + i) for i in range(6)])
    assert "has 4 waypoints" in refused(capsys, *level[:3], long, *board)
    served = "model:?checker=none&map_size=64"
    assert refused(capsys, *level, *board) == (
        "The board at '/dev/ttyUSB0' has no collision checker; use a bitstream with one, or model:."
    )
    assert len(is_closed) == 7


def test_works_on_a_check_only_chip(level, capsys):
    verdict = feasible(capsys, *level)
    assert feasible(capsys, *level, "--board", "model:?core=none") == verdict


# --- Bad input -----------------------------------------------------------------------------------


def array(name, values):
    def make(folder):
        np.save(folder / name, values)

    return make


def text(name, content):
    def make(folder):
        (folder / name).write_text(content)

    return make


def header(name, shape):
    """Return a maker of a file of 192 bytes that states an array of any size."""

    def make(folder):
        with (folder / name).open("wb") as file:
            told = {"descr": "<i8", "fortran_order": False, "shape": shape}
            np.lib.format.write_array_header_1_0(file, told)
            file.write(bytes(64))

    return make


@pytest.mark.parametrize(
    ("name", "make", "sentence"),
    [
        ("no.npy", lambda folder: None, "Cannot read the map '{}' (No such file or directory)."),
        (".", lambda folder: None, "Cannot read the map '{}' (Is a directory)."),
        ("t.npy", text("t.npy", "no array"),
         "{}: cannot be read as a numpy array; write it with numpy.save."),
        ("e.npy", text("e.npy", ""),
         "{}: cannot be read as a numpy array; write it with numpy.save."),
        ("o.npy", array("o.npy", np.array([[None]])),
         "{}: cannot be read as a numpy array; write it with numpy.save."),
        ("huge.npy", header("huge.npy", (10**6, 10**6)),
         "{}: its 1000000 x 1000000 cells are more than 25,000,000; cut it to the part that the "
         "path is in."),
        ("f.npy", array("f.npy", np.zeros((3, 4))),
         "{}: a map must be a filled array [y, x] of integers, not of shape (3, 4) of float64."),
        ("f.npy", array("f.npy", np.zeros(9, int)),
         "{}: a map must be a filled array [y, x] of integers, not of shape (9,) of int64."),
        ("f.npy", array("f.npy", np.zeros((0, 9), int)),
         "{}: a map must be a filled array [y, x] of integers, not of shape (0, 9) of int64."),
        ("w.npy", array("w.npy", np.zeros((9, 513), int)),
         "{}: the map has 513 x 9 cells, but the board's has 512 x 512; cut it, or give a "
         "simulated board a larger map_size."),
        ("h.npy", array("h.npy", np.array([[7, 4096]])),
         "{}: altitudes must be from 0 to 4095, not 7 to 4096."),
        ("h.npy", array("h.npy", np.array([[-1, 3]], np.int8)),
         "{}: altitudes must be from 0 to 4095, not -1 to 3."),
    ],
)  # fmt: skip
def test_refuses_bad_maps(level, tmp_path, capsys, name, make, sentence):
    make(tmp_path)
    said = refused(capsys, "--map", tmp_path / name, *level[2:])
    assert said == sentence.replace("{}", str(tmp_path / name))


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        ("a,b,c\n1,2,3\n", "{}: the first line must be the header x,y,z."),
        ("x,y,z\n1,2,3\n", "{}: a path needs two rows or more, the start first and the goal last."),
        ("x,y,z\n1,2,3\n1,2\n", "{}, line 3: must be three finite numbers x,y,z, not '1,2'."),
        ("x,y,z\n1,2,3\n1,2.5,3\n",
         "{}: point 2 must be whole cells and altitude steps, not 1,2.5,3."),
        ("x,y,z\n-1,2,3\n1,2,3\n",
         "{}: point 1 must be from 0,0,0 to 511,511,4095, not -1,2,3."),
        ("x,y,z\n1,2,3\n1,512,3\n",
         "{}: point 2 must be from 0,0,0 to 511,511,4095, not 1,512,3."),
        ("x,y,z\n1,2,3\n1,2,1e300\n",
         "{}: point 2 must be from 0,0,0 to 511,511,4095, not 1,2,1e+300."),
        ("x,y,z\n" + "1,2,3\n" * 19,
         "{}: the path has 17 waypoints between the aircraft and the goal, but the board holds 16; "
         "leave some out, or give a simulated board a larger max_waypoints."),
    ],
)  # fmt: skip
def test_refuses_bad_paths(level, tmp_path, capsys, rows, sentence):
    file = tmp_path / "bad.csv"
    file.write_text(rows)
    said = refused(capsys, *level[:3], file)
    assert said == sentence.replace("{}", str(file))


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--mode", "sideways"], "Argument --mode: there is no choice 'sideways'; choose from "),
        (["--board", "model:?checker=none"],
         "The board at 'model:?checker=none' has no collision checker; "),
        (["--board", "model:?core=none&checker=none"],
         "Config.core must be paper on a chip without a checker, not none; "),
        (["--board", "model:?checker=hierarchical"],
         "Config.checker must be none, two-tier or parallel, not 'hierarchical'; "),
        (["--board", "model:?checker=parallel", "--mode", "two-tier"],
         "The board at 'model:?checker=parallel' has the parallel checker of 1 lane, "
         "which does not serve --mode two-tier; leave --mode out."),
        (["--board", "model:?lanes=8", "--mode", "detailed"],
         "The board at 'model:?lanes=8' has the parallel checker of 8 lanes, which does not serve "
         "--mode detailed; leave --mode out."),
        (["--board", "model:?lanes=8"], "Config.lanes must be 1 in the two-tier build, not 8; "),
        (["--board", "/dev/nowhere"], "No board can be opened at '/dev/nowhere' ("),
    ],
)  # fmt: skip
def test_refuses_bad_boards(level, capsys, options, sentence):
    assert refused(capsys, *level, *options).startswith(sentence)


def test_reads_files_before_a_board_is_built(level, tmp_path, capsys, monkeypatch):
    def opened(url):
        raise AssertionError(url)

    monkeypatch.setattr(pathgene.host.device.boards, "open_board", opened)
    assert refused(capsys, *level[:3], tmp_path / "no.csv", "--board", "sim:").startswith(
        "Cannot read the path "
    )


def test_map_and_path_are_required(capsys):
    assert refused(capsys) == (
        "The following arguments are required: --map, --path; see pathgene feasible --help."
    )
