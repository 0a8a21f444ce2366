"""Compilation of the kernels of this package, and their cache on disk."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import TypeVar, cast

import numba
from numba import njit


__all__ = ["allocating", "compiled", "inlined"]

_Function = TypeVar("_Function", bound=Callable[..., object])


def compiled(function: _Function) -> _Function:
    """Compile a function that makes and copies no arrays; keep the result on disk.

    The function does not count the references to its arrays, as numba's functions do in every
    call: its caller holds them. The counts took a third of a run.

    The cache of numba notices changes in the file of the outermost function only; here it notices
    them in every source of this package and of the numbers that it shares with the gateware.
    """
    return _compiled(function)


def inlined(function: _Function) -> _Function:
    """Compile a function that is inlined where it is called; see :func:`compiled`.

    A call passes every field of every array, which takes longer than such a function.
    """
    return _compiled(function, inlines=True)


def allocating(function: _Function) -> _Function:
    """Compile a function that makes or copies arrays; see :func:`compiled`."""
    return _compiled(function, allocates=True)


def _compiled(function: _Function, *, inlines: bool = False, allocates: bool = False) -> _Function:
    # _nrt: numba's runtime, which makes arrays and counts the references to them.
    dispatcher = njit(
        cache=True, nogil=True, error_model="numpy", forceinline=inlines, _nrt=allocates
    )(function)
    kept = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if kept is not None:
        kept._source_stamp = _stamp()
        # In the version, too, which is read first.
        kept._version = f"{numba.__version__} {_stamp()}"
    return cast(_Function, dispatcher)


@cache
def _stamp() -> str:
    digest = hashlib.sha256()
    here = Path(__file__).resolve()
    for folder in (here.parent, here.parents[3] / "hdl", here.parents[3] / "hdl" / "protocol"):
        for file in sorted(folder.glob("*.py")):
            digest.update(file.read_bytes())
    return digest.hexdigest()
