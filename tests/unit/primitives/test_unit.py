"""Declared parameters of a unit: arguments, attributes, messages and docstring."""

import inspect

import pytest
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import (
    Choice,
    Count,
    Flag,
    Given,
    InstanceOf,
    PowerOfTwo,
    Unit,
    Width,
)


class Mixer(Unit):
    """Mixes words.

    Members
    -------
    word : In(word_bits)
    """

    taps: Count(1, "depth - 1", "Words that are mixed.")
    depth: PowerOfTwo(4, 16, also=(0,))
    word_bits: Width(1)
    labels: InstanceOf(dict)
    rows: PowerOfTwo(2, name="Rows of a block") = 8
    ports: Choice(1, 2, text="Ways in.") = 1
    signed: Flag("Words have a sign.") = False
    shape: Given("ShapeLike", "Shape of a mark.") = None

    def interface(self):
        self.total = self.taps * self.word_bits
        return {"word": In(self.word_bits)}


SIZES = {"taps": 3, "depth": 8, "word_bits": 5, "labels": {}}


class Wide(Mixer):
    """Mixes wide words."""

    factor: Count(2) = 4


class Fixed(Unit):
    """Has no parameters."""

    on: In(1)
    done: Out(1)


def test_arguments_are_attributes():
    mixer = Mixer(3, 8, word_bits=5, labels={"a": 1}, signed=3)
    assert (mixer.taps, mixer.depth, mixer.word_bits, mixer.labels) == (3, 8, 5, {"a": 1})
    assert (mixer.rows, mixer.ports, mixer.signed, mixer.shape) == (8, 1, True, None)
    assert (mixer.total, mixer.word.shape().width) == (15, 5)
    assert set(mixer.signature.members) == {"word"}


def test_subclasses_add_parameters_after_inherited_ones():
    made = Wide(**SIZES, factor=2)
    assert list(Wide.parameters) == [*Mixer.parameters, "factor"]
    assert "factor" not in Mixer.parameters
    assert (made.factor, made.total) == (2, 15)


def test_ports_can_be_annotations():
    assert set(Fixed().signature.members) == {"on", "done"}
    assert inspect.getdoc(Fixed) == "Has no parameters."


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("taps", 0, "ValueError: Taps must be from 1 to 7, not 0"),
        ("taps", 8, "ValueError: Taps must be from 1 to 7, not 8"),
        ("taps", 2.0, "TypeError: Taps must be an integer, not 2.0"),
        ("taps", True, "TypeError: Taps must be an integer, not True"),
        ("taps", None, "TypeError: Taps must be an integer, not None"),
        ("depth", 2, "ValueError: Depth must be a power of two from 4 to 16, not 2"),
        ("depth", 12, "ValueError: Depth must be a power of two from 4 to 16, not 12"),
        ("depth", 32, "ValueError: Depth must be a power of two from 4 to 16, not 32"),
        ("depth", -4, "ValueError: Depth must be a power of two from 4 to 16, not -4"),
        ("depth", "8", "TypeError: Depth must be an integer, not '8'"),
        ("word_bits", 0, "ValueError: Word width must be 1 or more, not 0"),
        ("rows", 3, "ValueError: Rows of a block must be a power of two from 2 on, not 3"),
        ("ports", 3, "ValueError: Ports must be 1 or 2, not 3"),
        ("labels", [], "TypeError: Labels must be a dict, not []"),
        ("other", 1, "TypeError: got an unexpected keyword argument 'other'"),
    ],
)
def test_wrong_arguments(name, value, message):
    with pytest.raises((TypeError, ValueError)) as caught:
        Mixer(**SIZES | {name: value})
    assert f"{caught.type.__name__}: {caught.value}" == message


def test_a_missing_argument():
    with pytest.raises(TypeError, match=r"^missing a required argument: 'labels'$"):
        Mixer(3, 8, 5)


def test_right_arguments():
    for values in ({"taps": 1}, {"taps": 7}, {"depth": 16}, {"word_bits": 10**6}, {"ports": 2}):
        Mixer(**SIZES | values)
    with pytest.raises(ValueError, match=r"^Taps must be from 1 to -1, not 3$"):
        Mixer(**SIZES | {"depth": 0})


def test_docstring():
    assert (
        inspect.getdoc(Mixer)
        == """Mixes words.

Parameters
----------
taps : int
    Taps, from 1 to depth - 1. Words that are mixed.
depth : int or 0
    Depth, a power of two from 4 to 16.
word_bits : int
    Word width, 1 or more.
labels : dict
rows : int, default 8
    Rows of a block, a power of two from 2 on.
ports : int, default 1
    Ports, 1 or 2. Ways in.
signed : bool, default False
    Words have a sign.
shape : ShapeLike, default None
    Shape of a mark.

Members
-------
word : In(word_bits)

Raises
------
TypeError, ValueError
    If a parameter has the wrong type, or is out of its range."""
    )
    assert str(inspect.signature(Mixer)).startswith("(taps, depth, word_bits, labels, rows=8,")
