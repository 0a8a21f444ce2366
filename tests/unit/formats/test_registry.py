"""The rows of the formats, and the tables of docs/files.md."""

import re
from pathlib import Path

import pytest

from pathgene.host.formats.registry import (
    FORMATS,
    choices,
    extra_names,
    files,
    usual,
    zone_files,
    zone_suffixes,
)
from pathgene.host.report.run_files import DATA, GRID


PAGE = Path(__file__).resolve().parents[3] / "docs" / "files.md"


def test_texts_are_made_of_the_rows():
    assert usual() == "plan,waypoints,kml"
    assert choices() == (
        "plan (QGroundControl, MAVSDK), waypoints (Mission Planner, MAVProxy, QGroundControl), "
        "kml (Google Earth and other viewers), geojson (geographic information systems) and html "
        "(any browser)"
    )
    assert extra_names() == "plan, waypoints, kml and html"
    assert zone_files() == (
        "GeoJSON, KML, KMZ, FAA, INAV, openAIP, ED-318, ED-269, OpenAir, a .fen, the fences "
        "of a .waypoints or the fences of a .plan"
    )
    assert sorted(zone_suffixes()) == [
        ".fen",
        ".geojson",
        ".geojsonl",
        ".geojsons",
        ".json",
        ".kml",
        ".kmz",
        ".openair",
        ".plan",
        ".txt",
        ".waypoints",
    ]
    assert set(DATA) == {GRID, *files().values()}


@pytest.mark.parametrize("row", FORMATS, ids=lambda row: row.name)
def test_a_module_has_the_functions_of_its_row(row):
    functions = {"write"} if row.file else set()
    functions |= {"recognises", "features"} if row.zones else set()
    functions |= {"read_path"} if row.path_suffix else set()
    functions |= {"holds_mission", "mission"} if row.missions else set()
    assert functions
    known = {"write", "recognises", "features", "read_path", "holds_mission", "mission"}
    found = known & set(vars(row.module))
    assert found == functions


def test_the_page_has_each_written_format():
    table = re.findall(r"^\| `(\w+)` \| `([\w.]+)` \| (.*?) \|$", PAGE.read_text(), re.MULTILINE)
    rows = [row for row in FORMATS if row.file]
    assert [(name, file) for name, file, _ in table] == [(row.name, row.file) for row in rows]
    for (_, _, readers), row in zip(table, rows, strict=True):
        assert readers.startswith((row.readers, f"[{row.readers}]"))


def test_the_page_has_each_format_of_zones():
    table = PAGE.read_text().partition("| file | zones |\n")[2].partition("\n\n")[0]
    names = [line.split(" | ")[0].strip("| `") for line in table.splitlines()[1:]]
    assert sorted(names) == [
        ".fen",
        ".plan",
        ".waypoints",
        "ED-269",
        "ED-318",
        "FAA",
        "GeoJSON",
        "INAV",
        "KML",
        "KMZ",
        "OpenAir",
        "openAIP",
    ]
    assert len(names) == sum(bool(row.zones) for row in FORMATS)
