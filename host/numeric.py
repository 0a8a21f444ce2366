"""Numbers from outside: from users, files and browsers.

The caller phrases the error; this module only decides which text is a number.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from numbers import Real
from typing import TYPE_CHECKING, Any, Literal, overload

from pathgene.host.errors import InputError


if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


__all__ = ["as_number", "integer", "is_number", "numbers", "parse", "real", "rows", "whole"]


def is_number(value: Any) -> bool:
    """Return whether ``value`` is a finite real number in the range of a float, and not a bool."""
    try:
        return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:
        return False


def integer(name: str, value: Any) -> int:
    """Return an integer, of numpy for example, as an int.

    Raises
    ------
    InputError
        If ``value`` is not an integer; the sentence begins with ``name``.
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
        If ``value`` is not a real number, or is an integer outside the range of a float; the
        sentence begins with ``name``.
    """
    try:
        if isinstance(value, Real) and not isinstance(value, bool):
            return float(value)
    except OverflowError:
        pass
    raise InputError(f"The {name} must be a number, not {value!r}.")


def as_number(value: Any) -> float:
    """Return a finite number as a float.

    Raises
    ------
    ValueError
        If ``value`` is not one.
    """
    if not is_number(value):
        raise ValueError("not a finite number")
    return float(value)


@overload
def numbers(values: Any, count: Literal[2]) -> tuple[float, float]: ...
@overload
def numbers(values: Any, count: Literal[3]) -> tuple[float, float, float]: ...
@overload
def numbers(values: Any, count: int) -> tuple[float, ...]: ...


def numbers(values: Any, count: int) -> tuple[float, ...]:
    """Return a sequence of ``count`` finite numbers as floats.

    Raises
    ------
    ValueError
        If ``values`` is anything else.
    """
    values = _sequence(values)
    if len(values) != count:
        raise ValueError(f"not {count} numbers")
    return tuple(map(as_number, values))


def rows(values: Any, columns: int) -> NDArray[np.float64]:
    """Return a sequence of rows of ``columns`` finite numbers, (n, columns) float64.

    Raises
    ------
    ValueError
        If ``values`` is anything else.
    """
    import numpy as np  # Imported here, because options of planners are read without it.

    return np.array([numbers(row, columns) for row in _sequence(values)]).reshape(-1, columns)


def parse(text: str) -> float:
    """Return the finite number in ``text``.

    Raises
    ------
    ValueError
        If there is no such number.
    """
    value = float(text)
    if not math.isfinite(value):
        raise ValueError("not a finite number")
    return value


def whole(text: str, most: int | None = None) -> int:
    """Return the number that is written in decimal digits.

    Raises
    ------
    ValueError
        If it is not such a text, its number is beyond ``most``, or it has more digits than Python
        reads: some thousands.
    """
    if not (text.isascii() and text.isdigit()):
        raise ValueError("not a whole number")
    value = int(text)
    if most is not None and value > most:
        raise ValueError(f"more than {most}")
    return value


def _sequence(values: Any) -> Sequence[Any]:
    """Return a list, a tuple or an array as a sequence."""
    if hasattr(values, "tolist"):
        values = values.tolist()
    if not isinstance(values, Sequence) or isinstance(values, bytes | bytearray):
        raise ValueError("no sequence")
    return values
