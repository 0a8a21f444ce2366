"""Compilation of the kernels for the CPU, and its cache on disk."""

import hashlib
import inspect
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import TypeVar, cast

import numba
from numba import njit


__all__ = ["allocating", "compiled", "inlined", "source_stamp"]

_Function = TypeVar("_Function", bound=Callable[..., object])
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
        kept._source_stamp = stamp
        # In the version, too, which is read first: the cache of other sources may hold objects of
        # classes that no longer exist, and must not be read.
        kept._version = f"{numba.__version__} {stamp}"
    return cast(_Function, dispatcher)


@cache
def source_stamp(folder: Path) -> str:
    """Return a digest of the sources that a kernel of ``folder`` may be made of."""
    digest = hashlib.sha256()
    for file in sorted({*_HERE.glob("*.py"), *folder.glob("*.py")}):
        digest.update(file.read_bytes())
    return digest.hexdigest()
