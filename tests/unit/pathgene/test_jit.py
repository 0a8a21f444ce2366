"""The cache of compiled kernels and its invalidation."""

import errno
import importlib.util
import logging
import sys
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import pytest
from numba.core.caching import IndexDataCacheFile

from pathgene.jit import source_stamp


INNER = """
from {} import inlined

@inlined
def inner(x):
    return {}
"""
OUTER = """
from kernel_inner import inner
from {} import compiled

@compiled
def outer(x):
    return 10 * inner(x)
"""


@pytest.fixture(params=["pathgene.host.evaluation.jit", "pathgene.sim.model.compiled"])
def load(tmp_path, monkeypatch, request):
    """Function that writes and imports both modules as a new process would."""
    # Python accepts bytecode of the same second and length as the file's own.
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def load(value):
        (tmp_path / "kernel_inner.py").write_text(INNER.format(request.param, value))
        (tmp_path / "kernel_outer.py").write_text(OUTER.format(request.param))
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


def test_stamp_covers_the_folders(tmp_path):
    empty = source_stamp((tmp_path,))
    (tmp_path / "one.py").write_text("1")
    source_stamp.cache_clear()
    assert source_stamp((tmp_path,)) != empty


def test_ignores_entries_of_removed_classes(load, monkeypatch):
    types = ModuleType("kernel_types")
    types.Pair = NamedTuple("Pair", [("a", int), ("b", int)])
    types.Pair.__module__ = types.__name__
    monkeypatch.setitem(sys.modules, types.__name__, types)
    assert load("x.a + x.b")(types.Pair(1, 3)) == 40
    del types.Pair
    assert load("x + 1")(1) == 20


def files(kernel, ending):
    return sorted(Path(kernel._cache._cache_file._cache_path).glob(f"kernel_outer*.{ending}"))


def cut(content):
    return content[: len(content) // 2]


def flip(content):
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


@pytest.mark.parametrize("harm", [cut, flip, lambda content: b"", lambda content: b"text"])
@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_compiles_a_damaged_kernel_anew(load, caplog, ending, harm):
    caplog.set_level(logging.INFO, "pathgene.kernels")
    (file,) = files_of = files(run(load), ending)
    content = file.read_bytes()
    file.write_bytes(harm(content))
    damaged = run(load)
    if ending == "nbc":  # A flipped bit of an index can be harmless.
        assert not damaged.stats.cache_hits
        assert len(caplog.messages) == 1
        assert caplog.messages[0].startswith("a compiled kernel is damaged (")
    assert sum(run(load).stats.cache_hits.values()) == 1
    assert files(damaged, ending) == files_of


def run(load):
    """Import the kernels as a new process would, and use one."""
    kernel = load("x + 1")
    assert kernel(1) == 20
    return kernel


def test_a_missing_file_is_no_damage(load, caplog):
    caplog.set_level(logging.INFO, "pathgene.kernels")
    for file in files(run(load), "nbc"):
        file.unlink()
    run(load)
    assert caplog.messages == []


def test_a_full_disk_costs_only_time(load, monkeypatch):
    def refuse(self, filepath):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(IndexDataCacheFile, "_open_for_write", refuse)
    assert files(run(load), "nb?") == []
