"""Good inputs of the command line, which :mod:`tests.support.bad_input.inputs` damages."""

import functools
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import rasterio

from pathgene.host.evaluation import Evaluator
from pathgene.host.formats.plan import plan_document
from pathgene.host.options.kinds import to_toml
from pathgene.host.problem.aircraft import load as load_aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.report.summary import describe_problem
from pathgene.host.terrain import Terrain
from tests.support.bad_input.options import LAND
from tests.support.host.missions import flight_of


ENDS = ((150.0, 150.0, 600.0), (1550.0, 1550.0, 600.0))
BETWEEN = (900.0, 1100.0, 650.0)


@functools.cache
def land() -> Terrain:
    """A terrain of 21 x 21 nodes with a place on Earth."""
    y, x = np.mgrid[:21, :21]
    heights = np.round(300 + 150 * np.sin(x / 4) * np.cos(y / 3))
    return Terrain("land", heights, 100.0, 100.0, "EPSG:32632", (500_000.0, 5_100_000.0))


@functools.cache
def problem() -> Problem:
    """A problem with a zone of each kind."""
    zones = (
        Circle(1000, 600, 150, name="tower", upper_m=900.0),
        Polygon(((300, 900), (500, 900), (400, 1200)), t0_s=10.0, t1_s=60.0),
    )
    return Problem(land(), *ENDS, zones=zones, wind=(3.0, -2.0), start_heading_deg=45.0)


@functools.cache
def summary() -> dict[str, Any]:
    """A summary of a path, without its record."""
    source = {"source": LAND, "fill_voids": False, "cell_m": None}
    return {
        **describe_problem(Evaluator(problem(), threads=1), source),
        "waypoints": [list(point) for point in (ENDS[0], BETWEEN, ENDS[1])],
        "feasible": True,
        "legs": [{"from": list(ENDS[0])}, {"from": list(BETWEEN)}],
    }


@functools.cache
def plan_file() -> dict[str, Any]:
    """The path of the summary as a ``.plan``."""
    path = np.array((ENDS[0], BETWEEN, ENDS[1]))
    made: dict[str, Any] = json.loads(json.dumps(plan_document(flight_of(problem(), path))))
    return made


@functools.cache
def table() -> dict[str, Any]:
    """A problem file."""
    aircraft = load_aircraft("silver-fox").to_dict()
    return {
        "terrain": {"source": LAND, "fill_voids": False},
        "mission": {"start": [*ENDS[0]], "goal": [*ENDS[1]], "via": [[*BETWEEN]], "wind": [1, 2]},
        "zones": [{"circle": [1000, 600, 150], "name": "tower"}, {"file": "../base/zones.kml"}],
        "aircraft": aircraft,
        "rules": {"clearance": 30.0, "ceiling": 2000.0, "reserve": 10.0},
        "planner": {"name": "ga-pc", "generations": 5, "seed": 1, "population": 16},
        "output": {"out": "out"},
    }


def zones() -> dict[str, Any]:
    """Zones as GeoJSON."""
    ring = [[9.01, 46.056], [9.013, 46.056], [9.012, 46.058], [9.01, 46.056]]
    shapes = [("Polygon", [ring]), ("MultiPolygon", [[ring]]), ("Point", [9.01, 46.055])]
    return {
        "type": "FeatureCollection",
        "features": [
            {
                "type": "Feature",
                "properties": {"name": kind, "radius_m": 100, "upper": 700, "t0": 5},
                "geometry": {"type": kind, "coordinates": coordinates},
            }
            for kind, coordinates in shapes
        ],
    }


KML = """<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark><name>wood</name><ExtendedData>
<Data name="lower"><value>0</value></Data><Data name="t1"><value>60</value></Data></ExtendedData>
<Polygon><extrude>1</extrude><altitudeMode>absolute</altitudeMode><outerBoundaryIs><LinearRing>
<coordinates>9.010,46.056,700 9.013,46.056,700 9.012,46.058,700 9.010,46.056,700</coordinates>
</LinearRing></outerBoundaryIs></Polygon></Placemark><Placemark><ExtendedData>
<Data name="radius_m"><value>90</value></Data></ExtendedData>
<Point><coordinates>9.01,46.055</coordinates></Point></Placemark></Document></kml>
"""
CSV = "x,y,z\n" + "".join(
    f"{x},{y},{z}\n" for x, y, z in (ENDS[0], BETWEEN, ENDS[1])
)  # fmt: skip
LINE = {
    "type": "Feature",
    "properties": {},
    "geometry": {
        "type": "LineString",
        "coordinates": [[9.002, 46.056, 600], [9.01, 46.06, 650], [9.02, 46.068, 600]],
    },
}
RECORD = {
    "problem": "x", "key": "y", "seed": 0, "fitness": 1.5, "feasible": True, "generations": 3,
    "evaluations": 30, "seconds": {"total": 1.0}, "history": [[0, 1.0, 0.9], [1, 1.5, 1.0]],
    "history_evaluations": [10, 20], "failure": None,
}  # fmt: skip
VIRTUAL = """<VRTDataset rasterXSize="21" rasterYSize="21"><SRS>EPSG:32632</SRS>
<GeoTransform>500000,100,0,5102100,0,-100</GeoTransform><VRTRasterBand dataType="Float32" band="1">
<SimpleSource><SourceFilename relativeToVRT="1">../base/land.tif</SourceFilename>
<SourceBand>1</SourceBand><SrcRect xOff="0" yOff="0" xSize="21" ySize="21"/>
<DstRect xOff="0" yOff="0" xSize="21" ySize="21"/></SimpleSource></VRTRasterBand></VRTDataset>
"""


def write_base(folder: Path) -> None:
    """Write the good files that cases refer to."""
    with (folder / "land.npz").open("wb") as file:
        land().save_npz(file, np.zeros(land().shape, dtype=bool))
    (folder / "land.tif").write_bytes(raster("EPSG:32632", 100.0, (500_000.0, 5_102_100.0)))
    (folder / "path.csv").write_text(CSV)
    (folder / "zones.kml").write_text(KML)
    (folder / "problem.toml").write_bytes(toml(table()))
    (folder / "summary.json").write_text(json.dumps(summary()))
    (folder / "map.npy").write_bytes(array(np.zeros((32, 32), np.int64)))
    (folder / "cells.csv").write_text("x,y,z\n1,1,5\n20,20,5\n")


def raster(crs: str | None, side: float, corner: tuple[float, float], **options: Any) -> bytes:
    """The land as a GeoTIFF."""
    with rasterio.MemoryFile() as memory:
        with memory.open(
            driver="GTiff", width=21, height=21, count=1, dtype="float32", crs=crs,
            transform=rasterio.transform.from_origin(*corner, side, side), **options,
        ) as file:  # fmt: skip
            file.write(land().elevation[None, ::-1].astype(np.float32))
        return bytes(memory.read())


def array(values: Any) -> bytes:
    """An array in numpy's format."""
    made = io.BytesIO()
    np.save(made, values)
    return made.getvalue()


def toml(document: dict[str, Any]) -> bytes:
    """Return a document in TOML."""
    lines = [f"{json.dumps(key)} = {to_toml(value)}" for key, value in document.items()]
    return "\n".join(lines).encode("utf-8", "surrogatepass")
