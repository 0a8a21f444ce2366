"""The recorder of goldens: its runs agree where they should."""

from tools.record import record_generations, record_paths


def test_link_modes_breed_the_same_populations():
    runs = record_generations(2, ["with map"]).values()
    populations = [run["populations"] for run in runs]
    assert len(populations) == 3
    assert populations[0] == populations[1] == populations[2]
    assert len(set(populations[0])) == len(populations[0]) == 50
    for run in runs:
        # The map matters.
        assert run["counters"]["redrawn"] > 0
        assert len(set(run["checks"])) == len(run["checks"])


def test_builds_agree_where_they_should():
    rows = record_paths(40)
    assert len(rows) == 8
    for mode in ("first hit", "counting"):
        one, *others = (
            [row[:-2] for row in rows[f"parallel, {lanes}, {mode}"]]
            for lanes in ("1 lane", "8 lanes", "16 lanes")
        )
        assert others == [one, one]
        collisions = sum(row[0] for row in one)
        assert 0 < collisions < len(one)
    assert any(row[4] for row in rows["two-tier, first hit"])
