"""``pathgene fly``."""

import json
import sys

import numpy as np
import pytest

from pathgene.host.cli import main


PATH = [(1000.0, 1000.0, 330.0), (3000.0, 2500.0, 400.0), (5200.0, 2800.0, 330.0)]


@pytest.fixture
def summary(tmp_path):
    """Write a run over hills: a path of any heights, with its terrain."""
    y, x = np.mgrid[:61, :81]
    elevation = 150 + 80 * np.sin(x / 9) * np.cos(y / 7)
    np.savez(tmp_path / "terrain.npz", elevation=elevation, dx_m=100.0, dy_m=100.0)

    def write(path=PATH, **more):
        content = {
            "waypoints": path,
            "terrain": {"source": "hills", "fill_voids": False, "cell_m": None},
            "nofly": [],
            "wind": [0.0, 0.0],
            "ds_m": 50.0,
            "as_paper": True,
        }
        file = tmp_path / "summary.json"
        file.write_text(json.dumps(content | more))
        return str(file)

    return write


def test_flies_a_summary(summary, tmp_path, capsys):
    assert main(["fly", summary(), "--wind", "4,0", "--gusts", "light", "--seed", "3"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("kept           yes\naircraft       silver-fox\nguidance       ideal\n")
    assert {"flight.json", "flight.png"} <= {file.name for file in tmp_path.iterdir()}
    content = json.loads((tmp_path / "flight.json").read_text())
    assert (content["wind"], content["gusts"], content["seed"]) == ([4, 0], "light", 3)


def test_prints_json_alone(summary, tmp_path, capfd):
    assert main(["fly", summary(), "--json", "--out", str(tmp_path / "new")]) == 0
    report = json.loads(capfd.readouterr().out)
    assert report["kept"] is True
    assert report["files"][0] == str(tmp_path / "new" / "flight.json")


def test_flight_through_the_ground_is_a_failure(summary, capsys):
    assert main(["fly", summary([PATH[0], (3000.0, 2500.0, 150.0), PATH[2]])]) == 1
    captured = capsys.readouterr()
    assert captured.out.startswith("kept           no\n")
    assert "under the ground" in captured.err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--aircraft", "jet"], "There is no flight model 'jet'; choose from silver-fox, c172p"),
        (["--gusts", "wild"], "Gusts must be one of none, light, moderate, severe, not 'wild'."),
        (["--wind", "30,0"], "A wind of 30 m/s is not below the airspeed"),
    ],
)
def test_bad_options_are_one_sentence(summary, capsys, options, message):
    assert main(["fly", summary(), *options]) == 2
    assert message in capsys.readouterr().err


def test_missing_extra_is_one_sentence(summary, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "jsbsim", None)
    assert main(["fly", summary()]) == 2
    assert "needs the extra pathgene[fly]: pip install" in capsys.readouterr().err


@pytest.mark.ci
def test_a_device_in_place_of_a_file_stays(summary, tmp_path):
    for name in ("flight.json", "flight.png"):
        (tmp_path / name).symlink_to("/dev/null")
    assert main(["fly", summary()]) == 0
    assert (tmp_path / "flight.json").is_symlink()
    assert (tmp_path / "flight.png").is_symlink()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--guidance", "inav"], "There is no guidance 'inav'; choose from ideal, ardupilot, px4"),
        (["--guidance", "px4"], "place on Earth"),
        (
            ["--guidance", "px4", "--popup", "goal:300@20"],
            "--guidance px4 flies an exported mission, which does not change in flight; leave",
        ),
    ],
)
def test_guidance_that_cannot_fly_is_refused(summary, tmp_path, capsys, options, message):
    assert main(["fly", summary(), *options]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "flight.json").exists()


@pytest.mark.ci
def test_flies_the_exported_mission(summary, capsys):
    place = {"source": "hills", "fill_voids": False, "cell_m": None}
    place |= {"crs": "EPSG:32632", "origin": [500_000.0, 5_200_000.0]}
    main(["fly", summary(terrain=place), "--guidance", "px4"])
    captured = capsys.readouterr()
    assert "guidance       px4, " in captured.out
    assert "flown with MIS_TKO_LAND_REQ 0." in captured.err
