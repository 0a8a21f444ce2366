"""The recorder: two recordings are equal, and it finds differences."""

import json
import math

import pytest

from tools.record import differences, main, record_generations, record_paths


def test_no_difference_of_equal_records():
    record = {"a": [1, 2.5, None], "b": {"c": "text"}}
    assert list(differences(record, json.loads(json.dumps(record)))) == []


def test_every_difference_is_named():
    before = {"gone": 1, "list": [1, 2, 3], "deep": {"float": 0.1, "kind": 1}, "same": [0]}
    after = {
        "list": [1, 5],
        "deep": {"float": math.nextafter(0.1, 1), "kind": 1.0},
        "same": [0],
        "late": {},
    }
    assert list(differences(before, after)) == [
        "/gone: gone",
        "/list: 3 entries, now 2",
        "/list/1: 2, now 5",
        "/deep/float: 0.1, now 0.10000000000000002",
        "/deep/kind: 1, now 1.0",
        "/late: new",
    ]


def test_a_record_compares_equal_until_it_is_altered(tmp_path, capsys):
    file = tmp_path / "record.json"
    command = [str(file), "--only", "frames"]
    assert main(command) == 0
    assert main([*command, "--compare"]) == 0
    assert capsys.readouterr().out == "0 differences\n"

    record = json.loads(file.read_text())
    record["frames"]["chips"][0]["exchanges"][0]["reply"]["frame"] = "00"
    file.write_text(json.dumps(record))
    assert main([*command, "--compare"]) == 1
    difference, count = capsys.readouterr().out.splitlines()
    assert difference.startswith("/frames/chips/0/exchanges/0/reply/frame: '00', now '")
    assert count == "1 difference"


def test_a_file_or_the_goldens_but_not_both(tmp_path, capsys):
    for arguments in ([], [str(tmp_path / "record.json"), "--goldens"]):
        with pytest.raises(SystemExit):
            main(arguments)
        assert "give either FILE.json or --goldens" in capsys.readouterr().err


def test_link_modes_breed_the_same_populations():
    runs = record_generations((2,), ("with map",)).values()
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
