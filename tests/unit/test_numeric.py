"""Numbers as users give them."""

from fractions import Fraction

import numpy as np
import pytest

from host.errors import InputError
from host.numeric import integer, real


@pytest.mark.parametrize("value", [3, np.int64(3), np.uint8(3), np.array(3)])
def test_integer(value):
    assert integer("seed", value) == 3
    assert type(integer("seed", value)) is int


@pytest.mark.parametrize("value", [1.5, 3.0, np.float64(3), "3", None, [3]])
def test_refuses_what_is_no_integer(value):
    with pytest.raises(InputError) as caught:
        integer("seed", value)
    assert str(caught.value) == f"The seed must be an integer, not {value!r}."


@pytest.mark.parametrize("value", [0.5, np.float32(0.5), Fraction(1, 2)])
def test_real(value):
    assert real("time limit", value) == 0.5
    assert type(real("time limit", value)) is float
    assert real("time limit", np.int64(2)) == 2


@pytest.mark.parametrize("value", ["1", None, 1j, [1.0], 10**400])
def test_refuses_what_is_no_real_number(value):
    with pytest.raises(InputError) as caught:
        real("time limit", value)
    assert str(caught.value) == f"The time limit must be a number, not {value!r}."
