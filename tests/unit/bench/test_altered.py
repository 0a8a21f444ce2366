"""A process imports a changed definition; all other processes keep the usual one."""

import importlib.util
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pytest

import pathgene.hdl.protocol.planner
from bench.altered import Alteration
from bench.chip_ablation import CHANGES


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
