"""The read report in a summary and in sentences."""

import json

import numpy as np
import pytest
import rasterio
from rasterio.transform import from_origin

from pathgene.host.cli import main
from pathgene.host.report.reading import sentences, warnings_in


ENDS = ("--agl", "--start", "300,300,80", "--goal", "2600,2600,80", "--planner", "astar")


@pytest.fixture(scope="module")
def coast(tmp_path_factory):
    """A GeoTIFF of 100 x 100 nodes of 30 m near the equator, whose western part is sea floor."""
    file = tmp_path_factory.mktemp("coast") / "coast.tif"
    heights = np.tile(np.linspace(-60.0, 240.0, 100, dtype=np.float32), (100, 1))
    with rasterio.open(
        file, "w", driver="GTiff", width=100, height=100, count=1, dtype="float32",
        crs="EPSG:32632", transform=from_origin(500_000, 100_000, 30, 30),
    ) as raster:  # fmt: skip
        raster.write(heights, 1)
    return file


@pytest.fixture(scope="module")
def zones(tmp_path_factory):
    """Zones of which one is on the map and one is a line."""
    file = tmp_path_factory.mktemp("zones") / "zones.geojson"
    square = [[9.012, 0.89], [9.014, 0.89], [9.014, 0.892], [9.012, 0.892], [9.012, 0.89]]
    shapes = (("Polygon", [square], "R-7"), ("LineString", square[:3], "wire"))
    features = [
        {
            "type": "Feature",
            "properties": {"name": name},
            "geometry": {"type": kind, "coordinates": coordinates},
        }
        for kind, coordinates, name in shapes
    ]
    file.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return file


def test_plan_says_what_it_read(coast, zones, tmp_path, capsys):
    out = tmp_path / "out"
    options = ("--nofly", zones, "--write", "html", "--out", out)
    assert main(list(map(str, ("plan", "--terrain", coast, *ENDS, *options)))) == 0
    said = capsys.readouterr().err
    assert "100 x 100 nodes" in said
    assert "EPSG:32632" in said
    assert "Warning: 2,000 heights lie below 0 m" in said
    assert '"wire"' in said
    summary = json.loads((out / "summary.json").read_text())
    assert summary["read"]["terrain"]["nodes"] == [100, 100]
    assert summary["read"]["zones"]["files"][0]["can_forbid"] == 1
    (warning,) = warnings_in(summary)
    assert warning.startswith("2,000 heights")
    assert "2,000 heights" in (out / "path.html").read_text()

    assert main(["export", str(out / "summary.json"), "--write", "kml"]) == 0
    assert warning in capsys.readouterr().err
    assert main(["check", "--terrain", str(coast), "--path", str(out / "summary.json")]) == 0
    assert "Warning: 2,000 heights" in capsys.readouterr().err


def test_a_plan_as_the_papers_says_what_it_read(coast, tmp_path, capsys):
    options = ("--as-paper", "--generations", 1, "--out", tmp_path)
    main(list(map(str, ("plan", "--terrain", coast, *ENDS, *options))))
    said = capsys.readouterr().err
    assert "100 x 100 nodes" in said
    assert "heights of -60 to 240 m" in said


def test_problem_check_and_terrain_info_say_it_too(coast, zones, tmp_path, capsys):
    problem = tmp_path / "problem.toml"
    problem.write_text(
        f'[terrain]\nsource = "{coast}"\n[mission]\nstart = [300, 300, 80]\n'
        f'goal = [2600, 2600, 80]\nagl = true\n[[zones]]\nfile = "{zones}"\n'
    )
    assert main(["problem", "check", str(problem), "--json"]) == 0
    read = json.loads(capsys.readouterr().out)["read"]
    assert {"terrain", "zones"} <= set(read)
    assert main(["terrain", "info", str(coast)]) == 0
    assert "2,000 heights" in capsys.readouterr().out


def test_a_summary_of_an_earlier_version_has_no_report():
    assert list(sentences(None)) == []
    assert warnings_in({}) == []


def test_check_says_what_the_run_read_of_its_terrain(coast, tmp_path, capsys):
    assert main(list(map(str, ("plan", "--terrain", coast, *ENDS, "--out", tmp_path)))) == 0
    said = capsys.readouterr().err.splitlines()
    planned = [line for line in said if "Terrain " in line or "heights lie below 0 m" in line]
    assert len(planned) == 2
    summary = tmp_path / "summary.json"
    assert main(["check", "--path", str(summary), "--json"]) == 0
    checked = capsys.readouterr()
    assert [line for line in checked.err.splitlines() if line in planned] == planned
    read = json.loads(checked.out)["read"]["terrain"]
    assert read == json.loads(summary.read_text())["read"]["terrain"]

    stated = json.loads(summary.read_text())
    for faulty in ({"remarks": []} | {"driver": "GTiff"}, {"remarks": [1]}, []):
        stated["read"]["terrain"] = faulty
        summary.write_text(json.dumps(stated))
        assert main(["check", "--path", str(summary)]) == 2
        assert "read must have a table terrain" in capsys.readouterr().err


@pytest.fixture(scope="module")
def turned(tmp_path_factory):
    """A grid of numpy's in a system whose north is about 10 degrees off."""
    file = tmp_path_factory.mktemp("turned") / "turned.npz"
    heights = np.tile(np.linspace(100.0, 240.0, 100), (100, 1))
    place = {"crs": "EPSG:3035", "origin": np.array([3_000_000.0, 3_000_000.0])}
    np.savez(file, elevation=heights, dx_m=30.0, dy_m=30.0, **place)
    return file


def test_a_grid_with_a_place_is_reported_like_a_raster(turned, tmp_path, capsys):
    ends = ("--agl", "--start", "900,900,80", "--goal", "2000,2000,80", "--planner", "astar")
    assert main(list(map(str, ("plan", "--terrain", turned, *ends, "--out", tmp_path)))) == 0
    said = capsys.readouterr().err
    assert f"Terrain {turned}" in said
    assert "EPSG:3035, warped to local metres" in said
    assert "Note: " in said
    assert main(["terrain", "info", str(turned), "--json"]) == 0
    projection = json.loads(capsys.readouterr().out)["read"]["projection"]
    assert projection["file"] == "EPSG:3035"
    assert projection["is_warped"]


def test_embedded_terrains_have_no_sentence_of_facts(capsys):
    from pathgene.host.terrain import load

    for name in ("jacksboro", "canyon"):
        read = {"terrain": load(name).reading.to_dict(), "zones": {}}
        assert not [line for line in sentences(read) if line.startswith("Terrain")]


def test_terrain_info_names_the_driver_and_the_declared_void(coast, turned, tmp_path, capsys):
    marked = tmp_path / "marked.tif"
    with rasterio.open(coast) as raster, rasterio.open(
        marked, "w", **{**raster.profile, "nodata": -9999.0}
    ) as written:  # fmt: skip
        written.write(raster.read(1), 1)
    for file, driver, void in ((marked, "GTiff", "-9999"), (turned, "numpy", "none")):
        assert main(["terrain", "info", str(file)]) == 0
        rows = dict(line.split("  ", 1) for line in capsys.readouterr().out.splitlines())
        assert rows["driver"].strip() == driver
        assert rows["declared void"].strip() == void
