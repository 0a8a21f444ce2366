"""Checks of the numbers that a unit is built from."""

import pytest

from pathgene.hdl.primitives.arguments import check_integer, check_power_of_two


@pytest.mark.parametrize(
    ("value", "limits"), [(1, (1,)), (10**9, (1,)), (4, (4, 16)), (16, (4, 16)), (-1, (-1, 0))]
)
def test_right_values(value, limits):
    check_integer("Width", value, *limits)


@pytest.mark.parametrize("value", [4.0, True, "4", None])
def test_wrong_kinds(value):
    with pytest.raises(TypeError, match=rf"^Width must be an integer, not {value!r}$"):
        check_integer("Width", value, 1)


@pytest.mark.parametrize(
    ("value", "limits", "rule"),
    [(0, (1,), "1 or more"), (3, (4, 16), "from 4 to 16"), (17, (4, 16), "from 4 to 16")],
)
def test_wrong_values(value, limits, rule):
    with pytest.raises(ValueError, match=rf"^Width must be {rule}, not {value}$"):
        check_integer("Width", value, *limits)


def test_powers_of_two():
    for value in (2, 4, 16):
        check_power_of_two("Lanes", value, 2, 16)
    for value in (0, 1, 3, 12, 32, -2):
        rule = f"^Lanes must be a power of two from 2 to 16, not {value}$"
        with pytest.raises(ValueError, match=rule):
            check_power_of_two("Lanes", value, 2, 16)
    with pytest.raises(TypeError, match=r"^Lanes must be an integer, not 4\.0$"):
        check_power_of_two("Lanes", 4.0, 2, 16)
