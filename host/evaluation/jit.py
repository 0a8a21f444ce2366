"""How the kernels are compiled for the CPU."""

from collections.abc import Callable
from typing import TypeVar, cast

from numba import njit


__all__ = ["compiled"]

_Function = TypeVar("_Function", bound=Callable[..., object])


def compiled(function: _Function) -> _Function:
    """Compile ``function`` at its first call, keep the result on disk and hold no lock in it.

    Division follows IEEE 754 and raises nothing; no arithmetic is reordered, so that results agree
    with the reference and are the same on every machine.
    """
    return cast(_Function, njit(cache=True, nogil=True, error_model="numpy")(function))
