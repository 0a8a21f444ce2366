"""The scenarios of the benchmarks, and the message about missing tiles."""

import pytest

from bench import scenarios
from bench.scenarios import EMBEDDED, SYNTHETIC, TILES, UNTUNED, missing, names, names_of, problem


def test_names_missing_tiles(tmp_path, monkeypatch):
    monkeypatch.setattr(scenarios, "_FOLDER", tmp_path)
    for name in TILES.values():
        (tmp_path / name).touch()
    assert names() == [EMBEDDED, *TILES]
    assert missing() == []
    (tmp_path / TILES["cdem"]).unlink()
    (tmp_path / TILES["alps"]).unlink()
    assert missing() == ["Not next to the repository, so left out: cdem, alps."]
    wanted = [*SYNTHETIC, "alps", "himalaya"]
    assert names_of(wanted) == [*SYNTHETIC, "himalaya"]
    assert missing(wanted) == ["Not next to the repository, so left out: alps."]
    assert missing(SYNTHETIC) == []


def test_untuned_ground_is_of_other_seeds():
    assert UNTUNED == ("canyon-101", "canyon-102", "river-101", "river-102")
    for name in UNTUNED:
        scenario = problem(name)
        assert scenario.terrain.source == f"synthetic, seed {name.rpartition('-')[2]}"
        usual = problem(name.partition("-")[0])
        assert scenario.terrain.elevation.shape == usual.terrain.elevation.shape
        assert scenario.terrain.ground(*scenario.start[:2]) == pytest.approx(scenario.start[2] - 60)
