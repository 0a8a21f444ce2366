"""Compilation of the kernels for the CPU, and its cache on disk."""

import contextlib
import hashlib
import inspect
import logging
import pickle
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba import njit
from numba.core.caching import IndexDataCacheFile


__all__ = ["allocating", "compiled", "inlined", "source_stamp"]

_Function = TypeVar("_Function", bound=Callable[..., object])
_LOG = logging.getLogger("pathgene.kernels")
_HERE = Path(__file__).resolve().parent


def compiled(function: _Function) -> _Function:
    """Compile ``function`` at its first call, keep the result on disk and hold no lock in it.

    Division follows IEEE 754 and raises nothing; no arithmetic is reordered, so results agree with
    the reference and are the same on every machine. A kernel cannot allocate: references are not
    counted, which would take most of the time of a small function.

    The cache on disk is that of numba, which notices changes only in the file of the outermost
    function; here it notices them in all sources beside that file and in this package.
    """
    return _compiled(function, inline=False)


def allocating(function: _Function) -> _Function:
    """Compile a function that makes arrays, and runs long enough for that; see :func:`compiled`."""
    return _compiled(function, inline=False, counted=True)


def inlined(function: _Function) -> _Function:
    """Compile a small function that is inlined where it is called; see :func:`compiled`.

    A call passes a problem's constants one by one, which takes longer than such a function.
    """
    return _compiled(function, inline=True)


def _compiled(function: _Function, *, inline: bool, counted: bool = False) -> _Function:
    dispatcher = njit(
        cache=True, nogil=True, error_model="numpy", forceinline=inline, _nrt=counted
    )(function)
    # There is no cache on disk if the compiler is off or no folder is writable.
    kept = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if kept is not None:
        stamp = source_stamp(Path(inspect.getfile(function)).resolve().parent)
        kept = _CheckedFiles(kept._cache_path, kept._index_name.removesuffix(".nbi"), stamp)
        dispatcher._cache._cache_file = kept
        # In the version, too, which is read first: the cache of other sources may hold objects of
        # classes that no longer exist, and must not be read.
        kept._version = f"{numba.__version__} {stamp}"
    return cast(_Function, dispatcher)


class _CheckedFiles(IndexDataCacheFile):  # type: ignore[misc]  # numba has no types.
    """The files in which numba keeps a kernel; one that is damaged is as good as none.

    numba itself would fail for ever at a torn file, and run the code of an altered one.
    """

    def save(self, key: Any, data: Any) -> None:
        """Keep a kernel, unless the disk takes nothing: that costs time alone."""
        with contextlib.suppress(OSError):
            super().save(key, data)

    def _load_index(self) -> dict[Any, Any]:
        try:
            return cast(dict[Any, Any], super()._load_index())
        except Exception as error:  # What pickle raises depends on the damage.
            _LOG.info("an index of compiled kernels is damaged (%s)", type(error).__name__)
            return {}

    def _load_data(self, name: str) -> Any:
        digest, dumped = super()._load_data(name)
        if hashlib.sha256(dumped).digest() != digest:
            raise ValueError("the digest differs")
        return pickle.loads(dumped)

    def load(self, key: Any) -> Any:
        """Return a kernel that was kept, or None."""
        try:
            return super().load(key)
        except Exception as error:
            _LOG.info("a compiled kernel is damaged (%s)", type(error).__name__)
            return None

    def _save_data(self, name: str, data: Any) -> None:
        dumped = self._dump(data)
        super()._save_data(name, (hashlib.sha256(dumped).digest(), dumped))


@cache
def source_stamp(folder: Path) -> str:
    """Return a digest of the sources that a kernel of ``folder`` may be made of."""
    digest = hashlib.sha256()
    for file in sorted({*_HERE.glob("*.py"), *folder.glob("*.py")}):
        digest.update(file.read_bytes())
    return digest.hexdigest()
