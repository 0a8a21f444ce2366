"""Checks of the numbers that a unit is built from."""

__all__ = ["check_integer", "check_power_of_two"]


def check_integer(name: str, value: object, lowest: int, highest: int | None = None) -> None:
    """Raise unless ``value`` is an integer from ``lowest`` to ``highest``, or without a limit.

    Raises
    ------
    TypeError
        If ``value`` is no integer.
    ValueError
        If it is out of its range. Both messages begin with ``name``.
    """
    value = _integer(name, value)
    if value < lowest or (highest is not None and value > highest):
        rule = f"{lowest} or more" if highest is None else f"from {lowest} to {highest}"
        raise ValueError(f"{name} must be {rule}, not {value!r}")


def check_power_of_two(name: str, value: object, lowest: int, highest: int) -> None:
    """Raise unless ``value`` is a power of two from ``lowest`` to ``highest``, both such powers.

    The errors are those of :func:`check_integer`.
    """
    value = _integer(name, value)
    if not lowest <= value <= highest or value & (value - 1):
        raise ValueError(f"{name} must be a power of two from {lowest} to {highest}, not {value!r}")


def _integer(name: str, value: object) -> int:
    if not isinstance(value, int) or isinstance(value, bool):
        raise TypeError(f"{name} must be an integer, not {value!r}")
    return value
