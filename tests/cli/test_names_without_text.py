"""Names of files and folders whose bytes are not UTF-8, which the system allows."""

import json

import pytest

from tests.support.bad_input.good_inputs import write_base

from .conftest import ENDS, run_here


ODD = "o\udcff"
PLAN = ("--planner", "astar", "--no-picture")


def test_an_output_folder(hills, tmp_path):
    """Files are written, and the end is a success, whatever standard output can show."""
    done = run_here("plan", "--terrain", hills, *ENDS, *PLAN, "--out", tmp_path / ODD)
    assert (done.returncode, "Internal error" in done.stderr) == (0, False), done.stderr
    assert "o\\udcff/summary.json" in done.stdout
    written = {file.name for file in (tmp_path / ODD).iterdir()}
    assert written == {"summary.json", "terrain.npz", "path.geojson"}
    done = run_here("check", "--path", tmp_path / ODD / "summary.json", "--json")
    assert json.loads(done.stdout)["feasible"] is True


def test_a_terrain_in_every_format(tmp_path, kept_kernels):
    write_base(tmp_path)
    land = (tmp_path / "land.npz").rename(tmp_path / f"{ODD}.npz")
    ends = ("--start", "150,150,600", "--goal", "1550,1550,600")
    formats = "plan,waypoints,kml,html,geojson"
    out = tmp_path / "out"
    done = run_here("plan", "--terrain", land, *ends, *PLAN, "--write", formats, "--out", out)
    assert (done.returncode, "Internal error" in done.stderr) == (0, False), done.stderr
    assert json.loads((out / "summary.json").read_text())["terrain"]["name"] == "o\\udcff"
    done = run_here("export", out / "summary.json", "--write", formats, "--out", tmp_path / "again")
    assert done.returncode == 0


@pytest.mark.parametrize("folder", ["out", ODD])
def test_a_problem_file_cannot_hold_such_a_name(hills, tmp_path, folder):
    file = tmp_path / f"{ODD}.toml"
    done = run_here(
        "plan", "--terrain", hills, *ENDS, *PLAN, "--out", tmp_path / folder, "--save-problem", file
    )
    if folder == ODD:
        assert done.returncode == 2
        assert done.stderr.endswith("', whose bytes are not UTF-8; rename the file or folder.\n")
        assert "A problem file cannot hold '" in done.stderr
        assert not file.exists()
    else:
        assert done.returncode == 0
        assert file.read_text().startswith(
            "# A problem of pathgene; plan it with: pathgene plan o\\"
        )
