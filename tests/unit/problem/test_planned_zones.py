"""Plans among the zones of random files: they avoid active zones and ignore inactive ones.

The zones are drawn here in degrees, and checked with PROJ and Shapely.
"""

import json
import random
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
import shapely
from pyproj import Transformer
from shapely.geometry import Polygon as Shape

from pathgene.host.errors import PathgeneError
from pathgene.host.mission.build import mission_of
from pathgene.host.mission.plan import plan
from pathgene.host.terrain import Terrain


FILES, MANY = 20, 500
CRS = "EPSG:32632"
ORIGIN = (500_000.0, 5_000_000.0)
TO_MAP = Transformer.from_crs(4326, CRS, always_xy=True)
DEPARTURE = datetime(2026, 5, 1, 9, tzinfo=UTC)
START, GOAL = (300.0, 300.0), (3700.0, 3600.0)
MARGIN_M = 25.0


def ground(rng):
    x, y = np.meshgrid(np.arange(41), np.arange(41))
    slope = rng.uniform(-1, 1), rng.uniform(-1, 1)
    return 300.0 + slope[0] * x + slope[1] * y


def draw(rng, number):
    """Return a feature of GeoJSON, its area on the map, its heights and its times."""
    x, y, size = rng.uniform(500, 3500), rng.uniform(500, 3500), rng.uniform(150, 900)
    angles = [2 * np.pi * (k + rng.uniform(0, 0.9)) / 6 for k in range(6)]
    corners = np.array([(x + size * np.cos(a), y + size * np.sin(a)) for a in angles])
    lon, lat = TO_MAP.transform(*(corners + ORIGIN).T, direction="INVERSE")
    ring = [list(each) for each in zip(lon.tolist(), lat.tolist(), strict=True)]
    kind = rng.choice(("plain", "high", "low", "over", "early", "late", "open"))
    layer = {"lowerReference": "AMSL", "upperReference": "AMSL", "uom": "m"}
    lower, upper = {"high": (900, 2000), "low": (0, 420), "over": (0, 5000)}.get(kind, (0, 3000))
    layer |= {"lower": lower, "upper": upper}
    hours = {"early": (-9, -2), "late": (30, 50)}.get(kind)
    properties = {
        "identifier": f"Z{number}",
        "country": "DEU",
        "type": "NO_RESTRICTION" if kind == "open" else "PROHIBITED",
        "variant": "COMMON",
    }
    if hours is not None:
        start, end = ((DEPARTURE + timedelta(hours=each)).isoformat() for each in hours)
        properties["limitedApplicability"] = [{"startDateTime": start, "endDateTime": end}]
    feature = {
        "type": "Feature",
        "properties": properties,
        "geometry": {"type": "Polygon", "coordinates": [[*ring, ring[0]]], "layer": layer},
    }
    is_idle = hours is not None or kind == "open"
    return feature, Shape(corners), (lower, upper), is_idle


def solve(terrain, features, folder, name):
    """Return the plan among the features, or None if there is none."""
    file = folder / f"{name}.geojson"
    file.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    mission = mission_of(
        {
            "start": (*START, 60.0),
            "goal": (*GOAL, 60.0),
            "agl": True,
            "nofly": [str(file)],
            "departure": DEPARTURE.isoformat(),
            "zone_margin": MARGIN_M,
        },
        terrain,
    )
    found = plan(mission, "astar")
    return found if found.evaluation.feasible else None


def check(seed, folder):
    """Plan a random file; return 1 if there is a path."""
    rng = random.Random(seed)
    terrain = Terrain("slope", ground(rng), 100.0, 100.0, CRS, ORIGIN)
    zones = [draw(rng, number) for number in range(rng.randint(2, 6))]
    active = [(area, heights) for _, area, heights, is_idle in zones if not is_idle]
    try:
        found = solve(terrain, [feature for feature, *_ in zones], folder, "all")
    except PathgeneError as error:
        # An end in an active zone: Shapely agrees.
        if "inside the no-fly zone Z" not in str(error):
            raise
        assert any(
            area.distance(shapely.Point(end)) == 0 for area, _ in active for end in (START, GOAL)
        )
        return 0
    idle_left_out = [feature for feature, _, _, is_idle in zones if not is_idle]
    alone = solve(terrain, idle_left_out, folder, "active")
    if found is None:
        assert alone is None, seed
        return 0
    assert alone is not None
    # Inactive zones change nothing.
    assert np.array_equal(found.path, alone.path), seed
    samples = found.evaluator.track(found.path).sample(5.0)
    points = shapely.points(samples.x, samples.y)
    for area, (lower, upper) in active:
        near = shapely.dwithin(area, points, MARGIN_M - 0.5)
        within = (samples.z > lower - MARGIN_M + 0.5) & (samples.z < upper + MARGIN_M - 0.5)
        assert not (near & within).any(), seed
    return 1


@pytest.mark.parametrize("seed", range(FILES))
def test_plans_keep_out_of_active_zones_alone(seed, tmp_path):
    check(seed, tmp_path)


@pytest.mark.long
def test_many_plans_keep_out_of_active_zones_alone(tmp_path):
    assert sum(check(seed, tmp_path) for seed in range(FILES, MANY)) > MANY / 3
