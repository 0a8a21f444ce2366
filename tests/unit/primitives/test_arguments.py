"""Check of the numbers that a unit is built from."""

import pytest

from hdl.primitives.arguments import check_integer


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
