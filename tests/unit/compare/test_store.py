"""Runs on disk: kept, skipped and refused."""

import contextlib
import dataclasses
import errno
import json
import random
import re

import pytest

from pathgene.host.compare.entrants import parse_entrants, problem_digest
from pathgene.host.compare.store import RunStore
from pathgene.host.errors import InputError
from pathgene.host.files.disk import using
from pathgene.host.problem.zones import Circle
from tools.faults.disk import FaultyDisk, Killed
from tools.faults.platter import Platter


RECORD = {
    "fitness": 1.25,
    "feasible": True,
    "generations": 0,
    "evaluations": 32,
    "seconds": {"total": 0.5},
    "history": [[0, 1.25, 1.0]],
    "history_evaluations": [32],
}


@pytest.fixture
def entrant(entrants):
    return entrants[1]


def test_keeps_runs(tmp_path, entrant):
    with RunStore(tmp_path, "p") as store:
        assert store.get(entrant, 3) is None
        assert store.add(entrant, 3, RECORD) == store.get(entrant, 3)
        # The runs are on the disk already, in case of a crash.
        assert json.loads(store.path.read_text())["fitness"] == 1.25
    with RunStore(tmp_path, "p") as store:
        found = store.get(entrant, 3)
        assert found.items() >= RECORD.items()
        assert found["seed"] == 3
        assert found["options"]["max_waypoints"] == 8
        assert store.get(entrant, 4) is None


def test_keeps_runs_of_other_options_separate(tmp_path, entrants):
    with RunStore(tmp_path, "p") as store:
        store.add(entrants[0], 3, RECORD)
    (other,) = parse_entrants("ga-fpga:generations=16", {}, {})
    with RunStore(tmp_path, "p") as store:
        assert store.get(other, 3) is store.get(entrants[1], 3) is None
        assert store.get(entrants[0], 3) is not None


@pytest.mark.parametrize("cut", [1, 20, -1])
def test_a_torn_line_loses_no_other_run(tmp_path, entrant, cut):
    with RunStore(tmp_path, "p") as store:
        store.add(entrant, 1, RECORD)
        whole = store.path.read_bytes()
        store.add(entrant, 2, RECORD)
        path = store.path
    path.write_bytes(whole + path.read_bytes()[len(whole) :][:cut])
    with RunStore(tmp_path, "p") as store:
        assert store.get(entrant, 1) is not None
        # A line that lacks only its newline is complete.
        assert (store.get(entrant, 2) is not None) == (cut == -1)
        store.add(entrant, 3, RECORD)
    with RunStore(tmp_path, "p") as store:
        assert store.get(entrant, 1) is not None
        assert store.get(entrant, 3) is not None


@pytest.mark.parametrize(
    "line",
    ["", "null", "[1]", '{"problem": "p"}', '{"problem": "p", "key": [], "seed": 1}', "\0\0\0"],
)
def test_skips_lines_that_are_not_runs(tmp_path, entrant, line):
    (tmp_path / "runs.jsonl").write_text(f"{line}\n")
    with RunStore(tmp_path, "p") as store:
        assert store.get(entrant, 1) is None


@pytest.mark.parametrize("options", [{}, {"lasting": True}, {"kill": True}])
def test_a_failing_disk_loses_at_most_the_run_that_it_refuses(tmp_path, entrant, options):
    def compare(folder):
        """Store the missing runs, as a command does; return the kept seeds."""
        done = []
        with contextlib.suppress(InputError, Killed), RunStore(folder, "p") as store:
            done += [seed for seed in range(3) if store.get(entrant, seed) is not None]
            for seed in range(len(done), 3):
                store.add(entrant, seed, RECORD)
                done.append(seed)
        return done

    (tmp_path / "count").mkdir()
    with using(disk := FaultyDisk()):
        assert compare(tmp_path / "count") == [0, 1, 2]
    for at in range(1, len(disk.calls) + 1):
        folder = tmp_path / str(at)
        folder.mkdir()
        with using(faulty := FaultyDisk(at, seed=at, **options)):
            done = compare(folder)
        assert faulty.failed
        # Not every file system can sync a folder.
        assert len(done) < 3 or faulty.refused == [f"sync_directory {at}"]
        kept = compare(folder)
        assert kept == [0, 1, 2]
        with RunStore(folder, "p") as store:
            assert all(store.get(entrant, seed).items() >= RECORD.items() for seed in range(3))


def test_a_disk_that_refuses_the_end_of_a_truncated_line_is_reported(tmp_path, entrant):
    """The file still holds the line's end when it is closed, and the disk refuses that, too."""
    with RunStore(tmp_path, "p") as store:
        store.add(entrant, 1, RECORD)
    store.path.write_bytes(store.path.read_bytes()[:-20])
    sentence = (
        f"Cannot write to {str(store.path)!r} (No space left on device); correct that and give the "
        "same command again."
    )
    disk = FaultyDisk(2, error=errno.ENOSPC, lasting=True)
    with using(disk), pytest.raises(InputError, match=f"^{re.escape(sentence)}$"):
        RunStore(tmp_path, "p")


def test_a_loss_of_power_keeps_a_run_that_a_killed_process_wrote(tmp_path, entrant):
    """Its line was not synced, but the next session counts it; the file's name is new, too."""
    platter = Platter(tmp_path)
    with using(FaultyDisk(5, kill=True, platter=platter)), pytest.raises(Killed):
        RunStore(tmp_path, "p").add(entrant, 0, RECORD)
    with using(FaultyDisk(platter=platter)), RunStore(tmp_path, "p") as store:
        kept = store.get(entrant, 0)
    assert kept is not None
    for seed in range(20):
        platter.lose(random.Random(seed))
        with RunStore(tmp_path, "p") as store:
            assert store.get(entrant, 0) == kept


def test_refuses_runs_of_another_problem(tmp_path, entrant):
    with RunStore(tmp_path, "p") as store:
        store.add(entrant, 1, RECORD)
        before = store.path.read_bytes()
    with pytest.raises(InputError) as caught:
        RunStore(tmp_path, "q")
    assert str(caught.value) == (
        f"The directory {str(tmp_path)!r} holds runs of another problem; give another with --out, "
        f"or remove {str(tmp_path / 'runs.jsonl')!r}."
    )
    assert (tmp_path / "runs.jsonl").read_bytes() == before


def test_refuses_a_second_session(tmp_path):
    with RunStore(tmp_path, "p"), pytest.raises(InputError) as caught:
        RunStore(tmp_path, "p")
    assert str(caught.value) == (
        f"Another comparison is writing to {str(tmp_path)!r}; wait for "
        "it, or give another directory with --out."
    )
    RunStore(tmp_path, "p").__exit__(None, None, None)


def test_digest_of_a_problem_covers_exactly_the_fitness(problem):
    terrain = problem.terrain
    raised = terrain.elevation.copy()
    raised[20, 30] += 1e-9
    changes = [
        {"terrain": dataclasses.replace(terrain, elevation=raised)},
        {"terrain": dataclasses.replace(terrain, dx_m=101.0)},
        {"start": (500.0, 500.0, 900.0)},
        {"goal": (5500.0, 3500.0, 900.0)},
        {"zones": ()},
        {"zones": (Circle(3000, 2000, 401),)},
        {"wind": (1.0, 0.0)},
        {"ds_m": 49.0},
        {"aircraft": dataclasses.replace(problem.aircraft, turn_radius_m=151.0)},
    ]
    digests = {problem_digest(dataclasses.replace(problem, **change)) for change in changes}
    assert len(digests | {problem_digest(problem)}) == len(changes) + 1
    renamed = dataclasses.replace(terrain, name="other", source="elsewhere")
    assert problem_digest(dataclasses.replace(problem, terrain=renamed)) == problem_digest(problem)


@pytest.mark.parametrize(
    "changes",
    [
        *({key: None} for key in RECORD),
        {"fitness": "1.25"},
        {"fitness": float("nan")},
        {"feasible": 1},
        {"evaluations": 10**400},
        {"seconds": {"total": []}},
        {"history": [[0]]},
        {"history": [["0", 1.25, 1.0]]},
        {"history": {"0": 1.25}},
        {"history_evaluations": [True]},
        {"key": []},
        {"seed": "3"},
    ],
    ids=str,
)
def test_a_line_of_other_values_is_skipped(tmp_path, entrant, changes):
    """The run is repeated, as after a truncated line."""
    with RunStore(tmp_path, "p") as store:
        line = store.add(entrant, 3, RECORD)
    store.path.write_text(json.dumps({**line, **changes}) + "\n" + "[" * 10_000 + "\n")
    with RunStore(tmp_path, "p") as store:
        assert store.get(entrant, 3) is None
        store.add(entrant, 3, RECORD)
    with RunStore(tmp_path, "p") as store:
        assert store.get(entrant, 3) == line
