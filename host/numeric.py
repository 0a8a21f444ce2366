"""Numbers as users give them: integers and real numbers of any type that Python counts as such."""

from __future__ import annotations

import math
import operator
from numbers import Real
from typing import Any

from host.errors import InputError


__all__ = ["integer", "is_number", "real"]


def is_number(value: Any) -> bool:
    """Return whether ``value`` is a finite real number, within the floats, and no bool."""
    try:
        return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:
        return False


def integer(name: str, value: Any) -> int:
    """Return an integer, of numpy for example, as an int.

    Raises
    ------
    InputError
        If ``value`` is no integer; the sentence begins with ``name``.
    """
    try:
        return operator.index(value)
    except TypeError:
        raise InputError(f"The {name} must be an integer, not {value!r}.") from None


def real(name: str, value: Any) -> float:
    """Return a real number as a float.

    Raises
    ------
    InputError
        If ``value`` is no real number, or an integer beyond the floats; the sentence begins with
        ``name``.
    """
    try:
        if isinstance(value, Real) and not isinstance(value, bool):
            return float(value)
    except OverflowError:
        pass
    raise InputError(f"The {name} must be a number, not {value!r}.")
