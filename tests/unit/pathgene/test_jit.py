"""The cache of compiled kernels and its invalidation."""

import errno
import importlib.util
import logging
import sys
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import pytest
from numba import njit
from numba.core import config
from numba.core.caching import (
    IndexDataCacheFile,
    InTreeCacheLocator,
    UserProvidedCacheLocator,
    UserWideCacheLocator,
)
from numba.core.codegen import CPUCodegen
from numba.core.registry import cpu_target

from pathgene.jit import BASELINE, baseline_target, is_kept, source_stamp


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

TRIPLE = "x86_64-unknown-linux-gnu"
# Level 3 of x86-64 by the ABI, in LLVM's names; LLVM does not list x87.
LEVEL_3 = (
    *("64bit", "cmov", "cx8", "fxsr", "mmx", "sse", "sse2"),
    *("crc32", "cx16", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2", "ssse3"),
    *("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave"),
)
FEATURES = ",".join(("+adx", *(f"+{name}" for name in LEVEL_3), "-avx512f"))


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


@pytest.fixture
def processor(monkeypatch):
    """Function that replaces the processor for which numba compiles by its name and features."""

    def replace(name, features):
        monkeypatch.setattr(CPUCodegen, "magic_tuple", lambda self: (TRIPLE, name, features))

    return replace


@pytest.fixture
def wheel(load, processor):
    """The sources with a kernel for the baseline, as in an installed wheel; the target is newer."""
    processor(BASELINE, "")
    folder = Path(run(load)._cache._cache_file._cache_path)
    processor("newer", FEATURES)
    return folder


def hits(kernel):
    return sum(kernel.stats.cache_hits.values())


def test_a_kernel_of_a_wheel_is_loaded(load, wheel):
    before = sorted(wheel.iterdir())
    kernel = run(load)
    assert (hits(kernel), is_kept(kernel)) == (1, True)
    assert sorted(wheel.iterdir()) == before


@pytest.mark.parametrize("missing", LEVEL_3)
def test_a_processor_without_a_feature_of_the_baseline(missing):
    assert baseline_target((TRIPLE, "newer", FEATURES)) == (TRIPLE, BASELINE, "")
    assert baseline_target((TRIPLE, "newer", FEATURES.replace(f"+{missing},", ""))) is None
    off = FEATURES.replace(f"+{missing},", f"-{missing},")
    assert baseline_target((TRIPLE, "newer", off)) is None


@pytest.mark.parametrize(
    "features", [FEATURES.replace("+fma", "-fma"), ""], ids=["no fma", "unknown"]
)
def test_such_a_processor_compiles(load, wheel, processor, features):
    processor("older", features)
    assert not is_kept(load("x + 1"))
    assert not hits(run(load))
    assert hits(run(load)) == 1
    # It does not take the kernel of the newer one.
    processor("newer", FEATURES)
    assert hits(run(load)) == 1


def test_the_kernel_of_the_very_processor_is_preferred(load, wheel, processor, monkeypatch):
    processor("newer", FEATURES)
    loaded = IndexDataCacheFile.load
    keys = []

    def recorded(self, key):
        keys.append(key[1][1])
        return loaded(self, key)

    monkeypatch.setattr(IndexDataCacheFile, "load", recorded)
    assert hits(run(load)) == 1
    assert keys == ["newer", BASELINE]


def test_a_kernel_of_other_sources_in_a_wheel_is_not_loaded(load, wheel):
    assert not hits(load("x + 2"))
    changed = load("x + 2")
    assert not is_kept(changed)
    assert changed(1) == 30
    assert not hits(changed)


def test_a_kernel_of_another_version_of_numba_is_not_loaded(load, wheel, monkeypatch):
    monkeypatch.setattr("numba.__version__", "0.0.1")
    assert not is_kept(load("x + 1"))
    assert not hits(run(load))


def test_a_folder_for_caches_has_only_new_kernels(load, wheel, tmp_path, monkeypatch):
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "caches"))
    assert hits(run(load)) == 1
    assert not list(tmp_path.rglob("caches/**/*.nb?"))
    assert load("x + 2")(1) == 30
    assert len(list(tmp_path.rglob("caches/**/kernel_outer*.nbc"))) == 1


def refuse(*arguments, **options):
    raise OSError(errno.EROFS, "Read-only file system")


@pytest.fixture
def read_only(monkeypatch):
    """Function that refuses to write caches, in the folder of the sources or in all."""

    def make(*locators):
        for locator in locators:
            monkeypatch.setattr(locator, "ensure_cache_path", refuse)
        if UserWideCacheLocator in locators:
            monkeypatch.setattr(IndexDataCacheFile, "_open_for_write", refuse)

    return make


def test_a_wheel_in_a_folder_that_is_read_only(load, wheel, read_only, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    read_only(InTreeCacheLocator)
    assert hits(run(load)) == 1
    assert load("x + 2")(1) == 30
    assert len(list(tmp_path.rglob("home/**/kernel_outer*.nbc"))) == 1
    again = load("x + 2")
    assert again(1) == 30
    assert hits(again) == 1


def test_nothing_can_be_written(load, wheel, read_only):
    read_only(InTreeCacheLocator, UserWideCacheLocator, UserProvidedCacheLocator)
    before = sorted(wheel.iterdir())
    assert hits(run(load)) == 1
    for _ in range(2):
        changed = load("x + 2")
        assert changed(1) == 30
        assert not hits(changed)
    assert sorted(wheel.iterdir()) == before


def test_a_kernel_is_kept_without_its_table_of_types(load):
    kernel = run(load)
    (data,) = files(kernel, "nbc")
    (table,) = kernel.inspect_types.__self__.overloads.values()
    assert "kernel_outer.py" in str(table.type_annotation)
    assert b"kernel_outer.py" not in data.read_bytes()


def test_bitcode_is_parsed_only_for_a_caller(load):
    load("x + 1")(2)
    sys.modules["kernel_inner"].inner(2.5)
    # As in a new process.
    outer = load("x + 1")
    inner = sys.modules["kernel_inner"].inner
    assert (inner(2.5), outer(2)) == (3.5, 30)
    (kept,) = [result.library for result in inner.overloads.values()]
    assert kept._parsed is None
    assert outer(2.5) == 35.0
    assert kept._parsed is not None


def test_a_cache_of_numba_itself_is_loaded(load):
    load("x + 1")(2)
    codegen = cpu_target.target_context.codegen()
    plain = njit(lambda x: x + 2)
    assert plain(1) == 3
    (library,) = [result.library for result in plain.overloads.values()]
    kept = library.serialize_using_object_code()
    assert kept[1] == "object"
    again = codegen.unserialize_library(kept)
    assert again.get_defined_functions() is not None
    assert again._shared_module is not None
