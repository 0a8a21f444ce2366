"""Tasks measured in processes: order, progress, failures and preparation."""

import importlib.util
import multiprocessing
import os
import re
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pytest

import pathgene.hdl.protocol.planner
from bench.campaign import Alteration, measure
from bench.chip_ablation import CHANGES
from pathgene.host.errors import InputError


prepared = []


def square(number, seconds=0.0):
    time.sleep(seconds)
    if number < 0:
        raise InputError(f"{number} is negative.")
    return number**2, os.getpid()


def prepare(word):
    prepared.append(word)


def words():
    return list(prepared)


def test_results_have_the_order_of_the_tasks(capsys):
    kept = []
    tasks = [(3, 0.3), (2, 0.0), (1, 0.0)]
    found = measure(
        "squares",
        tasks,
        square,
        name=lambda task: f"number {task[0]}",
        keep=lambda task, result: kept.append((task[0], result[0])),
    )
    assert [value for value, _ in found] == [9, 4, 1]
    assert os.getpid() not in {process for _, process in found}
    assert sorted(kept) == [(1, 1), (2, 4), (3, 9)]
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 3
    assert re.fullmatch(r"squares: number \d \(1 of 3, 0\.0 min\)", lines[0])


def test_tasks_of_one_name_are_reported_once(capsys):
    tasks = [(number,) for number in range(6)]
    measure("squares", tasks, square, name=lambda task: "even" if task[0] % 2 == 0 else "odd")
    lines = capsys.readouterr().err.splitlines()
    assert sorted(line.split()[1] for line in lines) == ["even", "odd"]
    assert lines[-1].endswith("(2 of 2, 0.0 min)")


def test_no_tasks():
    assert measure("squares", [], square, name=str) == []


def test_a_failed_task_ends_the_campaign_or_is_told():
    tasks = [(-1,), (2,)]
    with pytest.raises(InputError, match=r"^-1 is negative\.$"):
        measure("squares", tasks, square, name=str)
    told = []
    found = measure(
        "squares",
        tasks,
        square,
        name=str,
        failed=lambda task, error: told.append((task, str(error))),
    )
    assert [value for value, _ in found] == [4]
    assert told == [((-1,), "-1 is negative.")]


def test_an_error_of_keep_cancels_the_rest():
    kept = []

    def keep(task, result):
        kept.append(task)
        raise ValueError("full")

    tasks = [(number, 0.01) for number in range(400)]
    with pytest.raises(ValueError, match="full"):
        measure("squares", tasks, square, name=str, keep=keep)
    assert len(kept) == 1


@pytest.mark.parametrize("spawned", [False, True])
def test_each_process_prepares_once(spawned):
    found = measure(
        "words",
        [()] * 8,
        words,
        name=lambda _: "words",
        prepare=prepare,
        prepare_arguments=("ready",),
        spawned=spawned,
    )
    assert found == [["ready"]] * 8
    assert prepared == []


ALTERATION = Alteration(
    "pathgene.hdl.protocol.planner", "SEED_WAYPOINTS = 4, 16", "SEED_WAYPOINTS = 4, 8"
)


def seed_waypoints():
    # Imported in the process that alters it.
    from pathgene.hdl.protocol import planner

    return planner.SEED_WAYPOINTS, pathgene.hdl.protocol.planner.SEED_WAYPOINTS


def test_a_process_has_the_altered_module(tmp_path):
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, spawn, initializer=ALTERATION.apply, initargs=(tmp_path,)) as pool:
        assert pool.submit(seed_waypoints).result() == ((4, 8), (4, 8))
    assert pathgene.hdl.protocol.planner.SEED_WAYPOINTS == (4, 16)


def test_an_imported_module_cannot_be_altered(tmp_path):
    with pytest.raises(ValueError, match=r"^pathgene.hdl.protocol.planner cannot be altered$"):
        ALTERATION.apply(tmp_path)


@pytest.mark.parametrize("name", [n for n, c in CHANGES.items() if isinstance(c, Alteration)])
def test_what_a_row_alters_is_there_once(name):
    change = CHANGES[name]
    source = Path(importlib.util.find_spec(change.module).origin).read_text()
    assert source.count(change.old) == 1
    assert change.new != change.old


@pytest.mark.parametrize("spawned", [False, True])
def test_an_error_ends_the_other_workers(spawned):
    before = set(multiprocessing.active_children())
    began = time.monotonic()
    with pytest.raises(InputError, match="-1 is negative"):
        measure(
            "squares",
            [(1, 60.0), (-1,)],
            square,
            name=str,
            spawned=spawned,
            processes=2,
        )
    assert time.monotonic() - began < 30.0
    assert set(multiprocessing.active_children()) == before
