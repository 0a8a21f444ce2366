"""The smaller commands."""

import json

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import VERSION
from pathgene.host.cli import main
from pathgene.host.planners import PLANNERS
from pathgene.host.terrain import names


def output_of(capsys, *arguments):
    assert main([str(argument) for argument in arguments]) == 0
    return capsys.readouterr().out


def test_planners(capsys):
    listed = json.loads(output_of(capsys, "planners", "--json"))
    assert [entry["name"] for entry in listed] == list(PLANNERS)
    assert all(entry["paper"] and entry["description"] for entry in listed)
    engines = {entry["name"]: entry["engines"] for entry in listed}
    assert engines["fpa-2opt"] == ["threads", "sequential", "gpu"]
    assert engines["ga-fpga"] == engines["ga-chip"] == ["chip"]
    options = {entry["name"]: entry["options"] for entry in listed}
    assert {name for name, own in options.items() if "init" in own} == {*PLANNERS} - {
        "astar",
        "ga-chip",
    }
    with pytest.raises(SystemExit):
        main(["plan", "--help"])
    described = capsys.readouterr().out
    for option in {option for own in options.values() for option in own}:
        assert f"\n  --{option.replace('_', '-')} " in described
    table = output_of(capsys, "planners").splitlines()
    assert [line.split()[0] for line in table] == ["name", *PLANNERS]


def test_terrain_list(capsys):
    listed = json.loads(output_of(capsys, "terrain", "list", "--json"))
    assert [entry["name"] for entry in listed] == list(names())
    assert len(output_of(capsys, "terrain", "list").splitlines()) == len(listed) + 1


def test_terrain_info(capsys, hills):
    report = json.loads(output_of(capsys, "terrain", "info", hills, "--json"))
    assert (report["shape"], report["dx_m"], report["crs"]) == ([41, 61], 100.0, None)
    assert report["voids"] == 55
    assert "61 from west to east" in output_of(capsys, "terrain", "info", hills)
    filled = json.loads(output_of(capsys, "terrain", "info", hills, "--fill-voids", "--json"))
    assert filled["voids"] == 0


def test_terrain_synth(capsys, tmp_path):
    file = tmp_path / "new" / "river.npz"
    report = json.loads(
        output_of(capsys, "terrain", "synth", "river", "--seed", "4", "--out", file, "--json")
    )
    with np.load(file) as grid:
        assert list(grid["elevation"].shape) == report["shape"]
        assert float(grid["dx_m"]) == report["dx_m"]
        first = grid["elevation"]
    output_of(capsys, "terrain", "synth", "river", "--seed", "4", "--out", file)
    with np.load(file) as grid:
        assert np.array_equal(grid["elevation"], first)
    output_of(capsys, "terrain", "synth", "river", "--seed", "5", "--out", file)
    with np.load(file) as grid:
        assert not np.array_equal(grid["elevation"], first)


def test_board_info(capsys):
    url = "model:?max_waypoints=20"
    report = json.loads(output_of(capsys, "board", "info", "--board", url, "--json"))
    config = report["config"]
    assert config["max_waypoints"] == 20
    assert report["protocol"] == VERSION
    assert report["build_id"] == f"{Config(**config).build_id:08x}"
    assert "max_waypoints" in output_of(capsys, "board", "info", "--board", url)


def test_verilog(capsys, tmp_path):
    file = tmp_path / "selection.v"
    options = (
        "verilog",
        "--top",
        "selection",
        "--out",
        file,
        "--set",
        "max_waypoints=20",
        "--set",
        "survivor_selection=rank",
        "--json",
    )
    report = json.loads(output_of(capsys, *options))
    text = file.read_bytes()
    assert b"module selection(" in text
    assert report["bytes"] == len(text)
    config = Config(max_waypoints=20, survivor_selection="rank")
    assert report["build_id"] == f"{config.build_id:08x}"
    output_of(capsys, *options)
    assert file.read_bytes() == text


def test_old_names_are_read_with_a_note(capsys, tmp_path):
    options = ("verilog", "--out", tmp_path / "uart.v", "--top", "uart", "--json")
    assert main([*map(str, options), "--set", "genetic=0", "--set", "lanes=4"]) == 0
    printed, said = capsys.readouterr()
    assert said == "pathgene: The old name 'genetic=0' still works; write 'core=none'.\n"
    assert json.loads(printed)["build_id"] == f"{Config(core='none', lanes=4).build_id:08x}"
    assert main(["board", "info", "--board", "model:?genetic=streaming", "--json"]) == 0
    printed, said = capsys.readouterr()
    assert said == "pathgene: The old name 'genetic=streaming' still works; write 'core=planner'.\n"
    assert json.loads(printed)["config"]["core"] == "planner"


def test_check_takes_the_options_of_a_summary(capsys, tmp_path):
    """The options also apply to a given terrain: filling, cells and step."""
    ny, nx = 40, 60
    heights = np.full((ny, nx), 100.0)
    heights[:, 25:30] = np.nan  # A river of voids blocks the way.
    file = tmp_path / "river.npy"
    np.save(file, heights)
    out = tmp_path / "out"
    ends = ["--start", "100,1000,200", "--goal", "2800,1000,200"]
    options = ["--cell", "50", "--fill-voids", "--ds", "20", "--generations", "3"]
    planned = json.loads(
        output_of(capsys, "plan", "--json", "--terrain", file, *ends, *options, "--out", out)
    )
    checked = json.loads(
        output_of(capsys, "check", "--json", "--terrain", file, "--path", out / "summary.json")
    )
    for key in ("fitness", "penalty", "cost", "feasible", "ds_m"):
        assert checked[key] == planned[key], key
    assert planned["feasible"]

    summary = json.loads((out / "summary.json").read_text())
    broken = tmp_path / "broken.json"
    broken.write_text(json.dumps(summary | {"nofly": None}))
    assert main(["check", "--terrain", str(file), "--path", str(broken)]) == 2
    assert capsys.readouterr().err == (
        f"pathgene: {broken}: nofly must be a list of zones, not None.\n"
    )
    assert main(["check", "--ds", "0", "--path", str(out / "summary.json")]) == 2
