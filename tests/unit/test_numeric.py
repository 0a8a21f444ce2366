"""Numbers of users, files and browsers."""

from fractions import Fraction

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.numeric import as_number, integer, numbers, parse, real, rows, whole


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


@pytest.mark.parametrize("value", ["1", None, True, 1j, [1.0], 10**400, np.nan, np.inf])
def test_refuses_what_is_no_finite_number(value):
    with pytest.raises(ValueError, match="not a finite number"):
        as_number(value)


def test_sequences_of_numbers():
    assert numbers([1, np.float32(0.5)], 2) == (1.0, 0.5)
    assert all(type(value) is float for value in numbers(np.array([1, 2, 3]), 3))
    assert rows([[1, 2], (3, 4)], 2).tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert rows([], 3).shape == (0, 3)


@pytest.mark.parametrize("values", [None, 12, "12", {0: 1, 1: 2}, [1], [1, 2, 3], [1, "2"]])
def test_refuses_what_are_no_two_numbers(values):
    with pytest.raises(ValueError):
        numbers(values, 2)
    with pytest.raises(ValueError):
        rows([values], 2)


@pytest.mark.parametrize("values", [None, 5, "ab", {"a": 1}, [1, 2], [[1, 2], [3]], [[1, None]]])
def test_refuses_what_are_no_rows(values):
    with pytest.raises(ValueError):
        rows(values, 2)


@pytest.mark.parametrize("text", ["", "one", "nan", "1e999", "-inf", "1,5", "9" * 5000])
def test_refuses_a_text_that_states_no_finite_number(text):
    assert parse(" -2.5e1 ") == -25
    with pytest.raises(ValueError):
        parse(text)


@pytest.mark.parametrize("text", ["", "one", "-1", "+1", " 1", "1_0", "1.0", "٣", "²", "9" * 5000])
def test_refuses_a_text_that_states_no_whole_number(text):
    assert whole("007", 7) == 7
    with pytest.raises(ValueError):
        whole(text)


def test_refuses_a_whole_number_that_is_too_large():
    assert whole("9" * 400) == 10**400 - 1
    with pytest.raises(ValueError, match=r"^more than 7$"):
        whole("8", 7)
