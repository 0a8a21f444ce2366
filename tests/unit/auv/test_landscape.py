"""The landscapes equal their equations, and the compiled height equals the plain one."""

import math

import numpy as np
import pytest

from pathgene.host.auv.landscape import height, raw_height, scale
from pathgene.host.auv.measures import height as compiled_height
from pathgene.host.auv.measures import seabed
from pathgene.host.errors import InputError


def test_equations_one_and_two():
    x, y = 0.13, -0.31
    u, v = 4 * math.pi * x, 4 * math.pi * y
    r = math.sqrt(v**2 + u**2)
    first = math.sin(v + 0.5) + 1.3 * math.cos(u) - 0.3 * math.sin(3 * r) - 2 * math.sin(v)
    second = math.cos(v + 1.2) + 0.8 * math.sin(u) - 1.7 * math.sin(r) - math.cos(v)
    assert raw_height(1, x, y) == pytest.approx(first**2, rel=1e-12)
    assert raw_height(2, x, y) == pytest.approx(second**2, rel=1e-12)


@pytest.mark.parametrize("landscape", [1, 2])
def test_heights_reach_from_0_to_1(landscape):
    side = np.linspace(-0.5, 0.5, 2001)
    land = height(landscape, side[None, :], side[:, None])
    assert land.max() == pytest.approx(1, abs=1e-15)
    assert 0 <= land.min() < 1e-6


@pytest.mark.parametrize("landscape", [1, 2])
def test_compiled_height_is_the_same(landscape):
    points = np.random.default_rng(landscape).uniform(-0.5, 0.5, (500, 2))
    bed = seabed(landscape)
    compiled = np.array([compiled_height(bed, *point) for point in points])
    assert np.abs(compiled - height(landscape, *points.T)).max() < 1e-14


def test_has_two_landscapes():
    with pytest.raises(InputError, match=r"^The landscape must be one of 1, 2, not 3\.$"):
        scale(3)
