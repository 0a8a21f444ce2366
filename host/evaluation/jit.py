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

    Division follows IEEE 754 and raises nothing; no arithmetic is reordered, so that results agree
    with the reference and are the same on every machine. A kernel can allocate nothing: references
    are not counted, which in small functions takes longer than all they do.

    The cache on disk is that of numba, which looks for changes in the file of the outermost
    function alone; here it looks at all sources beside it and in this package.
    """
    return _compiled(function, inline=False)


def allocating(function: _Function) -> _Function:
    """As :func:`compiled`, for a function that makes arrays, and takes long enough for that."""
    return _compiled(function, inline=False, counted=True)


def inlined(function: _Function) -> _Function:
    """As :func:`compiled`, for a small function that is best copied to where it is called.

    A call hands over a problem's constants one by one, which takes longer than such a function.
    """
    return _compiled(function, inline=True)


def _compiled(function: _Function, *, inline: bool, counted: bool = False) -> _Function:
    dispatcher = njit(
        cache=True, nogil=True, error_model="numpy", forceinline=inline, _nrt=counted
    )(function)
    # Nothing is kept on disk where the compiler is off or no folder can be written.
    kept = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if kept is not None:
        stamp = source_stamp(Path(inspect.getfile(function)).resolve().parent)
        kept._source_stamp = stamp
        # In the version, too, which is read first: what other sources have left may be of classes
        # that are no more, and is not to be read at all.
        kept._version = f"{numba.__version__} {stamp}"
    return cast(_Function, dispatcher)


@cache
def source_stamp(folder: Path) -> str:
    """Digest of the sources that a kernel of ``folder`` may be made of."""
    digest = hashlib.sha256()
    for file in sorted({*_HERE.glob("*.py"), *folder.glob("*.py")}):
        digest.update(file.read_bytes())
    return digest.hexdigest()
