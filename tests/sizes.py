# amaranth: UnusedElaboratable=no
"""Check of a unit's sizes, which are parameters of its constructor."""

import re

import pytest


def check_sizes(unit, sizes, **others):
    """Each size is readable, and a wrong one is refused with the whole message.

    Parameters
    ----------
    unit : type
        Class of the component.
    sizes : dict of str to (str, int, str, tuple of int)
        Of each parameter: its name in messages, a right value, the rule, and wrong values.
    others
        Further parameters of the constructor.
    """
    right = {parameter: value for parameter, (_, value, _, _) in sizes.items()}
    made = unit(**right, **others)
    assert {parameter: getattr(made, parameter) for parameter in right} == right
    for parameter, (name, _, rule, values) in sizes.items():
        for value in ("1", 2.0, True):
            message = f"{name} must be an integer, not {value!r}"
            with pytest.raises(TypeError, match=f"^{re.escape(message)}$"):
                unit(**right | {parameter: value}, **others)
        for value in values:
            message = f"{name} must be {rule}, not {value}"
            with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
                unit(**right | {parameter: value}, **others)
