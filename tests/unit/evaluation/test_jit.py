"""The cache of compiled kernels and its invalidation."""

import importlib.util
import sys
from types import ModuleType
from typing import NamedTuple

import pytest

from host.evaluation.jit import source_stamp


INNER = """
from host.evaluation.jit import inlined

@inlined
def inner(x):
    return {}
"""
OUTER = """
from kernel_inner import inner
from host.evaluation.jit import compiled

@compiled
def outer(x):
    return 10 * inner(x)
"""


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Function that writes and imports both modules as a new process would."""

    def load(value):
        (tmp_path / "kernel_inner.py").write_text(INNER.format(value))
        (tmp_path / "kernel_outer.py").write_text(OUTER)
        source_stamp.cache_clear()
        for name in ("kernel_inner", "kernel_outer"):
            spec = importlib.util.spec_from_file_location(name, tmp_path / f"{name}.py")
            module = importlib.util.module_from_spec(spec)
            monkeypatch.setitem(sys.modules, name, module)
            spec.loader.exec_module(module)
        return module.outer

    return load


def test_notices_a_change_in_another_file(load):
    assert load("x + 1")(1) == 20
    again = load("x + 1")
    assert again(1) == 20
    assert sum(again.stats.cache_hits.values()) == 1
    changed = load("x + 2")
    assert changed(1) == 30
    assert not changed.stats.cache_hits


def test_stamp_covers_the_evaluation_and_the_folder(tmp_path):
    empty = source_stamp(tmp_path)
    (tmp_path / "one.py").write_text("1")
    source_stamp.cache_clear()
    assert source_stamp(tmp_path) != empty


def test_ignores_entries_of_removed_classes(load, monkeypatch):
    types = ModuleType("kernel_types")
    types.Pair = NamedTuple("Pair", [("a", int), ("b", int)])
    types.Pair.__module__ = types.__name__
    monkeypatch.setitem(sys.modules, types.__name__, types)
    assert load("x.a + x.b")(types.Pair(1, 3)) == 40
    del types.Pair
    assert load("x + 1")(1) == 20
