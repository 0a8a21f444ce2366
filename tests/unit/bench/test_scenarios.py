"""The scenarios of the benchmarks, and the message about missing tiles."""

from bench import scenarios
from bench.scenarios import EMBEDDED, SYNTHETIC, TILES, missing, names, names_of


def test_names_missing_tiles(tmp_path, monkeypatch):
    monkeypatch.setattr(scenarios, "_FOLDER", tmp_path)
    for name in TILES.values():
        (tmp_path / name).touch()
    assert names() == [EMBEDDED, *TILES]
    assert missing() == []
    (tmp_path / TILES["cdem"]).unlink()
    (tmp_path / TILES["alps"]).unlink()
    assert missing() == ["Not beside the repository, so left out: cdem, alps."]
    wanted = [*SYNTHETIC, "alps", "himalaya"]
    assert names_of(wanted) == [*SYNTHETIC, "himalaya"]
    assert missing(wanted) == ["Not beside the repository, so left out: alps."]
    assert missing(SYNTHETIC) == []
