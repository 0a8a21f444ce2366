"""Bad inputs of extreme size, in numbers, depth and length; odd names, and repetitions."""

import io
import json
import random
from typing import Any

import numpy as np

from tests.support.bad_input.good_inputs import KML, land, raster, zones
from tests.support.bad_input.options import CHECK, LAND, Case


def huge_terrain(rng: random.Random) -> Case:
    """A terrain whose cells, corner or heights are numbers that no map has."""
    odd = rng.choice((1e308, -1e308, 1e200, 1e155, 1e30, 1e12))
    if rng.random() < 0.5:
        keys = rng.sample(["dx_m", "dy_m"], rng.randint(1, 2))
        made: dict[str, Any] = {"elevation": land().elevation, "dx_m": 100.0, "dy_m": 100.0}
        made |= dict.fromkeys(keys, odd)
        if rng.random() < 0.5:
            system = rng.choice(("EPSG:32632", "EPSG:3857", "EPSG:2056"))
            made |= {"crs": system, "origin": (rng.choice((0.0, odd)), 0.0)}
        file = io.BytesIO()
        np.savez(file, **made)
        return Case("huge terrain", ("terrain", "info", "x.npz"), {"x.npz": file.getvalue()}, True)
    crs = rng.choice((None, "EPSG:32632", "EPSG:4326", "EPSG:3857", "EPSG:2056"))
    content = raster(crs, rng.choice((100.0, 0.001)), (rng.choice((odd, 0.0)), odd))
    return Case("huge terrain", ("terrain", "info", "x.tif"), {"x.tif": content}, True)


def deep_zones(rng: random.Random) -> Case:
    """A file of zones that is deep, wide, or has as many corners as a land register."""
    depth = rng.choice((2000, 20_000))
    kind = rng.choice(("Folder", "Placemark", "MultiGeometry", "outerBoundaryIs", "corners"))
    if kind == "corners":
        corners = [[9.01 + 1e-7 * n, 46.056 + 1e-5 * (n % 2)] for n in range(100 * depth)]
        document = zones()
        document["features"][0]["geometry"]["coordinates"] = [corners]
        files = {"x.geojson": json.dumps(document).encode()}
        return Case("deep zones", (*CHECK, "--nofly", "x.geojson"), files, True)
    begin, end = f"<{kind}>" * depth, f"</{kind}>" * depth
    outer = rng.choice(("Document", "Placemark"))
    text = KML.replace(f"<{outer}>", f"<{outer}>{begin}", 1)
    at = text.rindex(f"</{outer}>") if outer == "Document" else text.index(f"</{outer}>")
    files = {"x.kml": (text[:at] + end + text[at:]).encode()}
    return Case("deep zones", (*CHECK, "--nofly", "x.kml"), files)


def dotted_keys(rng: random.Random) -> Case:
    """A problem or an aircraft of thousands of keys with many parts."""
    parts, count = rng.choice(((150, 3000), (199, 1000), (20, 20_000)))
    shared = rng.random() < 0.5
    lines = [
        ".".join([f"k{n}" if not shared else "k", *"a" * (parts - 2), f"b{n}"]) + " = 1"
        for n in range(count)
    ]
    content = "\n".join(lines).encode()
    arguments = rng.choice((("problem", "check", "x.toml"), (*CHECK, "--uav", "x.toml")))
    return Case("dotted keys", arguments, {"x.toml": content}, True)


def odd_name(rng: random.Random) -> Case:
    """A file or folder whose name is no text, or empty, for a command that writes or reads it."""
    name = rng.choice(("x\udcff", "\udcfe", "x\udcff.npz", "x\udcff.toml", "", "."))
    arguments = rng.choice(
        (
            ("terrain", "synth", "canyon", "--out", name),
            ("problem", "new", name),
            ("export", "../base/summary.json", "--out", name),
            (*CHECK, "--nofly", name),
            ("check", "--terrain", name, "--path", "../base/path.csv"),
            ("check", "--path", name),
        )
    )
    return Case(f"odd name, {arguments[0]}", arguments, {}, name == "")


def repeated(rng: random.Random) -> Case:
    """An option or a setting of one value that is given twice."""
    two = rng.choice(
        (
            ("--terrain", LAND, "--terrain", LAND),
            ("--seed", "1", "--seed", "1"),
            ("--planners", "ga-pc:population=8:population=9"),
            ("--planners", "ga-pc:population=8:population=8"),
            ("--planners", "ga-pc:refits=1:refits=2,ga-dp"),
        )
    )
    ends = ("--start", "150,150,600", "--goal", "1550,1550,600")
    planners = () if "--planners" in two else ("--planners", "ga-pc")
    place = () if "--terrain" in two else ("--terrain", LAND)
    return Case("repeated", ("compare", *place, *ends, *planners, *two, "--out", "out"), {}, True)
