"""With thousands of no-fly zones, a plan with its picture takes only moments."""

import json
import random
import time

from tests.cli.conftest import plan


#: Processor seconds of a plan with a picture among 5,000 circles.
MOST_S = 6.0


def circles(file, count):
    """Write circles of 5 to 15 m next to the route as GeoJSON."""
    rng = random.Random(1)
    features = []
    while len(features) < count:
        x, y = rng.uniform(0, 6000), rng.uniform(0, 4000)
        if abs(3 * x - 5 * y + 1000) > 5000:  # 860 m from the straight line.
            features.append(
                {
                    "type": "Feature",
                    "properties": {"radius_m": rng.uniform(5, 15), "name": f"zone {len(features)}"},
                    "geometry": {"type": "Point", "coordinates": [x, y]},
                }
            )
    document = {"type": "FeatureCollection", "crs_local": True, "features": features}
    file.write_text(json.dumps(document))
    return file


def test_five_thousand_circles(hills, tmp_path):
    """It took 22 s when each zone was drawn, tested and rasterized by itself."""

    def planned(count):
        out = tmp_path / str(count)
        zones = circles(tmp_path / f"{count}.geojson", count)
        begun_s = time.process_time()
        assert plan(hills, out, "--nofly", zones, "--planner", "astar") == 0
        spent_s = time.process_time() - begun_s
        assert len(json.loads((out / "summary.json").read_text())["nofly"]) == count + 1
        assert (out / "path.png").stat().st_size > 10_000
        return spent_s

    planned(300)  # It compiles for the second plan: more than 200 circles are drawn together.
    assert planned(5000) < MOST_S
