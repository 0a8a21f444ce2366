"""The scene of a plan: heights, tracks, zones and figures that equal the plan's."""

import base64
import json

import numpy as np
import pytest

from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.problem.zones import Circle, Zone
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.surface import surface_below
from pathgene.host.web import scene as scenes
from pathgene.host.web.scene import plan_scene, problem_scene, terrain_scene, zones_scene
from tests.support.host.web_plans import KINDS, evaluated, hills, planned, with_mission


COLUMNS = ("s", "x", "y", "z", "ground", "clearance", "demanded")


def scene_of(kind):
    plan = planned(kind)
    return plan, plan_scene(plan.evaluator, plan.path, plan.summary)


def heights(terrain):
    """Decode the heights of a scene."""
    values = np.frombuffer(base64.b64decode(terrain["heights"]), "<u2")
    decoded = terrain["low_m"] + terrain["step_m"] * values.astype(float)
    return np.where(values == 65535, np.nan, decoded).reshape(terrain["rows"], terrain["columns"])


def columns(track):
    """Decode the columns of a track."""
    decoded = {key: np.frombuffer(base64.b64decode(track[key]), "<f4") for key in COLUMNS}
    assert {len(column) for column in decoded.values()} == {track["samples"]}
    return decoded


@pytest.mark.parametrize("kind", KINDS)
def test_every_scene_is_json_and_states_the_verdict(kind):
    plan, scene = scene_of(kind)
    assert json.loads(json.dumps(scene, allow_nan=False)) == scene
    assert scene["verdict"]["feasible"] is plan.evaluation.feasible
    assert bool(scene["verdict"]["sentence"]) is not plan.evaluation.feasible or kind == "as paper"
    assert scene["title"] == "hills"
    assert scene["paths"][0]["waypoints"] == plan.path.tolist()


@pytest.mark.parametrize("kind", KINDS)
def test_figures_are_those_of_the_summary(kind):
    plan, scene = scene_of(kind)
    summary = plan.summary
    own = [figure for figure in scene["figures"] if not figure["key"].startswith("legs")]
    assert {figure["key"]: figure["value"] for figure in own} == {
        figure["key"]: summary[figure["key"]] for figure in own
    }
    expected = {"length_m", "minimum_clearance_m", "fuel_N", "fitness"}
    if kind != "as paper":
        expected |= {"flight_time_s", "clearance_m", "max_height_agl_m", "range_left_m"}
    assert expected <= {figure["key"] for figure in own}


def test_a_mission_states_points_and_legs():
    plan, scene = scene_of("mission")
    kinds = [point["kind"] for point in scene["points"]]
    assert kinds == ["start", "via", "via", "goal", "return"]
    legs = [figure for figure in scene["figures"] if figure["key"].startswith("legs")]
    assert [figure["value"] for figure in legs] == [leg["length_m"] for leg in plan.summary["legs"]]
    assert [figure["label"] for figure in legs] == ["Leg 1", "Leg 2", "Leg 3", "Leg 4"]


def test_says_why_there_is_no_path_and_where_it_breaks_a_limit():
    plan, scene = scene_of("not feasible")
    assert scene["verdict"]["sentence"] == f"No path: {plan.reason.sentence}"
    broken = scene["paths"][0]["track"]["broken"]
    assert [tuple(each.values()) for each in broken] == [
        tuple(each) for each in plan.evaluator.broken(plan.path)
    ]
    assert broken


@pytest.mark.parametrize("kind", KINDS)
def test_a_track_is_that_of_the_evaluator(kind):
    plan, scene = scene_of(kind)
    track = scene["paths"][0]["track"]
    found = columns(track)
    own = plan.evaluator.track(plan.path)
    assert track["length_m"] == own.length_m
    fine = own.sample(1.0)
    assert found["s"][0] == 0
    assert found["s"][-1] == pytest.approx(own.length_m)
    for name in "xyz":
        expected = np.interp(found["s"], fine.s, getattr(fine, name))
        assert found[name] == pytest.approx(expected, abs=0.02)
    inside = ~np.isnan(found["clearance"])
    assert (found["clearance"] <= found["z"] - found["ground"] + 0.01)[inside].all()
    if kind == "as paper":
        assert np.isnan(found["demanded"]).all()
    else:
        surface = surface_below(plan.evaluator.problem.terrain, found["x"], found["y"])
        known = np.isfinite(surface)
        # The surface jumps halfway between nodes, which the rounding of a place may cross.
        off_m = np.abs(found["ground"] - surface)[known]
        assert (off_m > 0.05).sum() <= 3
        assert (np.isnan(found["ground"]) == ~known).all()


def test_the_least_clearance_of_a_track_is_that_of_the_verdict():
    plan, scene = scene_of("plain")
    found = columns(scene["paths"][0]["track"])
    lowest = int(np.nanargmin(found["clearance"]))
    assert found["clearance"][lowest] == pytest.approx(plan.evaluation.minimum_clearance_m)
    assert found["s"][lowest] == pytest.approx(plan.evaluator.lowest_at_m(plan.path))
    # The path keeps the required clearance.
    assert (found["z"] >= found["demanded"] - 0.01).all()


def test_heights_come_back_to_a_step():
    terrain = hills(void=True)
    scene = terrain_scene(terrain)
    assert scene["thinned"] is False
    assert (np.isnan(heights(scene)) == terrain.voids).all()
    assert np.nanmax(np.abs(heights(scene) - terrain.elevation)) <= 0.51 * scene["step_m"]


def test_flat_land_has_its_height():
    scene = terrain_scene(Terrain("salt", np.full((3, 4), 12.5), 10, 10))
    assert (heights(scene) == 12.5).all()
    assert scene["vertical"] == 3


@pytest.mark.parametrize("shape", [(513, 40), (700, 1500), (1, 1)])
def test_a_thinned_mesh_hides_no_peak_and_no_void(shape):
    rows, columns_ = shape if shape != (1, 1) else (2048, 2048)
    rng = np.random.default_rng(5)
    land = rng.uniform(0, 100, (rows, columns_))
    places = rng.integers(0, (rows, columns_), (40, 2))
    land[tuple(places[:20].T)] = 500 + np.arange(20)
    land[tuple(places[20:].T)] = np.nan
    terrain = Terrain("noise", land, 10, 10)
    scene = terrain_scene(terrain)
    mesh = heights(scene)
    assert mesh.shape == (min(rows, 512), min(columns_, 512))
    assert scene["thinned"] is True
    assert scene["nodes"] == [rows, columns_]
    assert (scene["width_m"], scene["height_m"]) == (terrain.width_m, terrain.height_m)
    # The node of the mesh next to each place has its height, or is a void.
    for (row, column), height in zip(places, land[tuple(places.T)], strict=True):
        near = mesh[
            round(row * (mesh.shape[0] - 1) / (rows - 1)),
            round(column * (mesh.shape[1] - 1) / (columns_ - 1)),
        ]
        assert np.isnan(near) or near >= height - scene["step_m"]
        assert np.isnan(near) or not np.isnan(height)


def test_zones_have_their_outlines_and_limits():
    scene = problem_scene(planned("plain").evaluator.problem)
    circle, polygon = scene["zones"]
    assert circle["circle"] == {"x": 1500, "y": 1150, "radius_m": 220}
    around = np.array(circle["rings"][0]) - (1500, 1150)
    assert np.hypot(*around.T) == pytest.approx(220, abs=0.1)
    assert (circle["lower_m"], circle["upper_m"]) == (None, None)
    assert polygon["rings"][0] == [[1900, 1500], [2500, 1500], [2500, 2100], [1900, 2100]]
    assert len(polygon["rings"]) == 2
    assert (polygon["lower_m"], polygon["upper_m"]) == (500, 700)
    assert polygon["text"] == "range\n500 to 700 m"
    assert scene["paths"] == scene["figures"] == []


def test_of_too_many_zones_the_smallest_are_left_out(monkeypatch):
    monkeypatch.setattr(scenes, "_MOST_CORNERS", 72 * 3)
    zones = [Circle(100 * radius, 100, radius) for radius in (5, 1, 9, 3, 7)]
    assert [zone["circle"]["radius_m"] for zone in zones_scene(zones)] == [5, 9, 7]
    ring = [(np.cos(a), np.sin(a)) for a in np.linspace(0, 6, 5000)]
    (alone,) = zones_scene([Zone.polygon(np.array(ring) * 1000)])
    assert len(alone["rings"][0]) <= 22


def test_a_straight_path_over_large_land_keeps_its_samples():
    evaluator, path = evaluated(hills(600, 900))
    scene = plan_scene(evaluator, path, {})
    assert scene["verdict"] == {"feasible": None, "sentence": ""}
    assert scene["paths"][0]["track"]["samples"] <= 1520


def test_a_mission_is_in_the_scene_of_a_map_with_a_place_alone():
    plan = with_mission()
    mission = plan_scene(plan.evaluator, plan.path, plan.summary)["paths"][0]["mission"]
    exported = flight_plan(plan.evaluator.problem, plan.evaluator.track(plan.path))
    circle = exported.end.circle
    assert mission["circles"] == [
        {
            "x": circle.x_m,
            "y": circle.y_m,
            "z": circle.z_m,
            "radius_m": circle.radius_m,
            "disc_m": circle.disc_m,
        }
    ]
    assert len(mission["rally"]) == len(exported.rally)
    assert mission["items"][0] == pytest.approx(plan.path[0], abs=0.1)
    for kind in ("plain", "not feasible"):
        assert scene_of(kind)[1]["paths"][0]["mission"] is None
