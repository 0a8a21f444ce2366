"""Files that were misread, if they are at hand."""

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.mission.build import load_problem
from pathgene.host.terrain import load
from pathgene.host.terrain.stated import Stated
from tests.support.host.cases import case


def test_no_ground_lies_below_the_water():
    terrain = load(case("01-sea-floor-as-ground/topobathy.tif"))
    assert terrain.lowest == 0
    assert "68.25% of the map" in terrain.reading.warnings[0]


def test_web_mercator_is_no_frame_of_metres():
    files = (case(f"02-web-mercator/{name}60.tif") for name in ("merc", "geo"))
    mercator, geographic = map(load, files)
    assert mercator.dx_m == pytest.approx(30.95, abs=0.01)
    rng = np.random.default_rng(2)
    x, y = rng.uniform(1500, 4000, (2, 200))
    lat, lon = geographic.to_geographic(x, y)
    apart = np.abs(mercator.ground(*mercator.to_local(lat, lon)) - geographic.ground(x, y))
    assert np.median(apart) < 2.0


def test_a_mark_without_a_tag_is_a_void():
    tagged, untagged = (
        load(case(f"03-void-without-tag/pit_{name}.tif")) for name in ("tagged", "untagged")
    )
    np.testing.assert_array_equal(tagged.elevation, untagged.elevation)
    assert tagged.voids.sum() == 3200


def test_a_plane_in_feet():
    bare, full = (
        case(f"10-feet-without-unit/stateplane_ft{name}.tif") for name in ("", "_navd88ft")
    )
    with pytest.raises(InputError, match=r"state it \(--height-unit m\|ft\|us-ft\)\.$"):
        load(bare)
    stated, known = load(bare, stated=Stated(height_unit="us-ft")), load(full)
    assert known.crs == "EPSG:2274"
    np.testing.assert_allclose(stated.elevation, known.elevation, atol=0.02)


def test_control_points_are_no_place():
    with pytest.raises(InputError, match=r"has control points instead of a place; warp it to them"):
        load(case("23-small-messages/gcps_only.tif"))


def test_a_byte_order_mark(tmp_path):
    text = case("23-small-messages/bom.toml").read_bytes()
    assert text.startswith(b"\xef\xbb\xbf")
    (tmp_path / "a.toml").write_bytes(
        '\ufeff[terrain]\nsource = "canyon"\n[mission]\nstart = [300, 300, 60]\n'
        "goal = [4700, 4600, 60]\nagl = true\n".encode()
    )
    assert load_problem(tmp_path / "a.toml").problem.terrain.name == "canyon"
