import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pathgene.host.errors import InputError
from pathgene.host.problem.chip_map import ChipMap
from pathgene.host.terrain import Terrain


@dataclass
class Sizes:
    """Sizes of a chip that the map needs."""

    map_size: int = 16
    blocked_altitude: int = 4095


@dataclass
class Place:
    """Terrain with no-fly nodes; start and goal default to the highest ground of the box."""

    terrain: Terrain
    nofly_raster: np.ndarray = None
    start: tuple = None
    goal: tuple = None
    box: tuple = None

    def __post_init__(self):
        if self.nofly_raster is None:
            self.nofly_raster = np.zeros(self.terrain.shape, bool)
        if self.box is None:
            self.box = tuple(slice(0, nodes) for nodes in self.terrain.shape)
        top = (0.0, 0.0, np.nanmax(self.elevation))
        self.start, self.goal = self.start or top, self.goal or top
        self.surface = self.terrain
        self.blocked_raster = self.nofly_raster | self.terrain.voids

    def search_part(self, rows, columns):
        return self.surface.elevation[rows, columns], self.blocked_raster[rows, columns]

    @property
    def elevation(self):
        """Elevation of the nodes in the box."""
        return self.terrain.elevation[self.box]

    @property
    def origin_m(self):
        rows, columns = self.box
        return columns.start * self.terrain.dx_m, rows.start * self.terrain.dy_m


@st.composite
def places(draw):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    shape = draw(st.tuples(st.integers(2, 40), st.integers(2, 40)))
    relief_m = draw(st.sampled_from((0.0, 0.5, 300.0, 6000.0)))
    heights = draw(st.floats(-400, 2999)) + relief_m * rng.random(shape)
    heights[rng.random(shape) < 0.05] = np.nan
    heights[0, 0] = 1.0
    sides = draw(st.tuples(st.floats(0.3, 200), st.floats(0.3, 200)))
    box = None
    if draw(st.booleans()):
        first = [draw(st.integers(0, nodes - 2)) for nodes in shape]
        last = [draw(st.integers(at + 2, nodes)) for at, nodes in zip(first, shape, strict=True)]
        box = tuple(map(slice, first, last))
        heights[tuple(first)] = 1.0
    return Place(Terrain("t", heights, *sides), rng.random(shape) < 0.05, box=box)


def nearest(index, side_m, scale_m):
    return math.floor(index * side_m / scale_m + 0.5)


@given(places())
@settings(max_examples=60, deadline=None)
def test_heights_match_an_exhaustive_search(place):
    sizes, terrain = Sizes(), place.terrain
    chip = ChipMap(sizes, place, place.box)
    expected = np.full((16, 16), -1)
    for (iy, ix), height in np.ndenumerate(place.elevation):
        cell = (
            nearest(iy, terrain.dy_m, chip.scale_m[1]),
            nearest(ix, terrain.dx_m, chip.scale_m[0]),
        )
        if math.isnan(height) or place.nofly_raster[place.box][iy, ix]:
            step = 4095
        else:
            step = math.ceil((Fraction(height) - Fraction(chip.base_m)) / Fraction(chip.step_m))
        expected[cell] = max(expected[cell], step)
    expected[expected == -1] = 4095
    assert chip.heights.dtype == np.uint16
    np.testing.assert_array_equal(chip.heights, expected)


@given(places())
@settings(max_examples=60, deadline=None)
def test_every_cell_decodes_exactly_and_onto_the_terrain(place):
    chip, terrain = ChipMap(Sizes(), place, place.box), place.terrain
    rng = np.random.default_rng(0)
    cells = rng.integers(0, np.array(chip.limits) + 1, (200, 3))
    cells[0], cells[1] = 0, chip.limits
    metres = chip.to_metres(cells)
    # On terrain that begins elsewhere, the origin is added and rounded.
    rows, columns = place.box
    far = np.array(((columns.stop - 1) * terrain.dx_m, (rows.stop - 1) * terrain.dy_m))
    assert (metres[:, :2].max(axis=0) <= np.nextafter(far, np.inf)).all()
    assert metres[1, :2] == pytest.approx(far, rel=1e-11)
    assert metres[0, :2].tolist() == list(place.origin_m)
    np.testing.assert_array_equal(chip.to_cells(metres), cells)
    for (x, y, z), (i, j, k) in zip(metres[:5].tolist(), cells[:5].tolist(), strict=True):
        assert Fraction(z) == Fraction(chip.base_m) + k * Fraction(chip.step_m)
        if columns.start == 0 and place.elevation.shape[1] > 16:
            assert Fraction(x) == i * Fraction(chip.scale_m[0])
        if rows.start == 0 and place.elevation.shape[0] > 16:
            assert Fraction(y) == j * Fraction(chip.scale_m[1])


@given(places(), st.integers(1, 4093), st.sampled_from((-np.inf, 0.0, np.inf)))
@settings(max_examples=60, deadline=None)
def test_altitudes_just_below_a_step_round_down(place, step, towards):
    chip = ChipMap(Sizes(), place, place.box)
    z = chip.base_m + step * chip.step_m
    z = np.nextafter(z, towards) if towards else z
    (cell,) = chip.to_cells(np.array([[*place.origin_m, z]]))
    assert cell[2] == math.floor((Fraction(z) - Fraction(chip.base_m)) / Fraction(chip.step_m))
    assert chip.to_metres(cell[None])[0, 2] <= z


@given(places())
@settings(max_examples=60, deadline=None)
def test_step_is_the_least_that_fits_relief_and_headroom(place):
    chip = ChipMap(Sizes(), place, place.box)
    lowest, highest = float(np.nanmin(place.elevation)), float(np.nanmax(place.elevation))
    top = highest + max(150.0, 0.1 * (highest - lowest))
    # Exact, because in floats a tiny negative number less 1 is -1.
    assert Fraction(lowest) - 1 < Fraction(chip.base_m) <= Fraction(lowest)
    assert (chip.step_m * 64).is_integer()
    assert chip.top_m >= top
    assert chip.base_m + 4094 * (chip.step_m - 1 / 64) < top


def test_a_small_terrain_by_hand():
    # 0 to 100 m with 150 m of headroom over 4094 steps: 250 / 4094 = 0.0611, rounded up to 4 / 64.
    heights = [[0.0, 0.03, 100.0], [np.nan, 50.0, 0.0625]]
    nofly = np.array([[False, False, False], [False, True, False]])
    chip = ChipMap(Sizes(map_size=4), Place(Terrain("t", heights, 30, 20), nofly))
    assert (chip.scale_m, chip.base_m, chip.step_m) == ((30.0, 20.0), 0.0, 0.0625)
    assert chip.heights.tolist() == [
        [0, 1, 1600, 4095],
        [4095, 4095, 1, 4095],
        [4095] * 4,
        [4095] * 4,
    ]
    assert chip.report() == {
        "size": 4,
        "scale_m": [30.0, 20.0, 0.0625],
        "offset_m": [0.0, 0.0, 0.0],
        "top_m": 255.875,
        "limits": [2, 1, 4094],
        "padding_cells": [1, 2],
    }


def test_a_large_terrain_by_hand():
    # 7 nodes 10 m apart on 4 cells: 20 m to a cell, nodes 0 | 1 2 | 3 4 | 5 6.
    row = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]
    chip = ChipMap(Sizes(map_size=4), Place(Terrain("t", [row, row], 10, 10)))
    assert chip.scale_m == (20.0, 10.0)
    # 156 m over 4094 steps: 3 / 64 m.
    assert (chip.base_m, chip.step_m) == (1.0, 0.046875)
    assert chip.heights[0].tolist() == [math.ceil(above / 0.046875) for above in (0, 2, 4, 6)]


def test_a_box_by_hand():
    row = [500.0, 1.0, 2.0, 3.0, 4.0, 500.0]
    place = Place(Terrain("t", [row] * 4, 10, 20), box=(slice(1, 4), slice(1, 5)))
    chip = ChipMap(Sizes(map_size=4), place, place.box)
    assert (chip.scale_m, chip.origin_m) == ((10.0, 20.0), (10.0, 20.0))
    assert not chip.is_whole
    # 153 m over 4094 steps: 3 / 64 m.
    assert (chip.base_m, chip.step_m) == (1.0, 0.046875)
    steps = [math.ceil(above / 0.046875) for above in (0, 1, 2, 3)]
    assert chip.heights.tolist() == [steps] * 3 + [[4095] * 4]
    assert chip.report()["offset_m"] == [10.0, 20.0, 1.0]
    assert chip.to_cells(np.array([[40.0, 20.0, 1.0]])).tolist() == [[3, 0, 0]]
    sentence = r"outside the chip's map, which reaches from 10,20,1 to 40,60,192.906 m\.$"
    with pytest.raises(InputError, match=sentence):
        chip.to_cells(np.array([[4.9, 20.0, 5.0]]))


@pytest.mark.parametrize(
    "point",
    [
        (-6.0, 0, 5),
        (25.1, 0, 5),
        (0, -5.1, 5),
        (0, 15.0, 5),
        (0, 0, -0.1),
        (0, 0, 1e4),
        (np.nan, 0, 5),
        (0, 0, np.nan),
        (0, 0, np.inf),
    ],
)
def test_refuses_points_outside(point):
    chip = ChipMap(Sizes(), Place(Terrain("t", [[0.0, 1, 2], [3, 4, 5]], 10, 10)))
    with pytest.raises(
        InputError,
        match=r"^The point .* is outside the chip's map, which reaches "
        r"from 0,0,0 to 20,10,\d+\.?\d* m\.$",
    ):
        chip.to_cells(np.array([[0.0, 0.0, 0.0], point]))


@pytest.mark.parametrize("end", ["start", "goal"])
def test_refuses_an_end_above_the_map(end):
    # 10 m of ground and 150 m above it; 4094 steps of 3 / 64 m reach 191.90625 m above 10 m.
    place = Place(Terrain("t", np.full((3, 3), 10.0), 30, 30), **{end: (0.0, 0.0, 5000.0)})
    with pytest.raises(InputError) as error:
        ChipMap(Sizes(), place)
    assert str(error.value) == (
        f"The {end}'s altitude of 5000 m is above the 201.906 m that the chip's map can hold over "
        "this terrain; lower it."
    )
