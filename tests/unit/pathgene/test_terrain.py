"""The terrain of the public API, from an array and from files."""

import numpy as np
import pytest

import pathgene.host.terrain
from pathgene import InputError, Problem, Terrain


HEIGHTS = [[10, 20, 30], [40, 50, np.nan]]


def test_from_array():
    made = Terrain.from_array(HEIGHTS, (20, 30), name="mine")
    assert (made.name, made.shape, made.dx_m, made.dy_m) == ("mine", (2, 3), 20.0, 30.0)
    assert made.ground(0, 0) == 10
    assert made.ground(20, 30) == 50
    assert made.voids.sum() == 1
    assert isinstance(made, pathgene.host.terrain.Terrain)
    filled = Terrain.from_array(HEIGHTS, 25, fill_voids=True)
    assert (filled.dx_m, filled.dy_m, filled.voids.sum()) == (25.0, 25.0, 0)


def test_from_array_with_a_place():
    made = Terrain.from_array(HEIGHTS, 30, crs="EPSG:32616", origin=(740_000.0, 4_010_000.0))
    start, goal = made.to_geographic(5, 5), made.to_geographic(30, 25)
    assert made.to_local(*goal) == pytest.approx((30, 25), abs=1e-6)
    problem = Problem(made, (*start, 50), (*goal, 60), geo=True, agl=True, as_paper=True)
    assert (problem.start[2], problem.goal[2]) == (60, 110)


@pytest.mark.parametrize(
    ("elevation", "cell_m", "message"),
    [
        ([1, 2, 3], 10, r"^terrain: the heights must be a grid of rows and columns"),
        (HEIGHTS, 0, r"^terrain: the sides of a cell must be positive metres"),
        ([[np.nan] * 2] * 2, 10, r"^terrain: every node is void"),
        ([["a", "b"]] * 2, 10, r"^terrain: the heights must be real numbers"),
    ],
)
def test_refuses_bad_arrays(elevation, cell_m, message):
    with pytest.raises(InputError, match=message):
        Terrain.from_array(elevation, cell_m)


@pytest.mark.parametrize("cell_m", ["a", "ab", None, [100], [1, 2, 3], ["a", "b"], 1j, [[1, 2]]])
def test_refuses_a_cell_that_is_not_one_number_or_two(cell_m):
    with pytest.raises(InputError) as caught:
        Terrain.from_array(HEIGHTS, cell_m)
    assert str(caught.value) == (
        f"The size of a cell must be one number of metres or two, not {cell_m!r}."
    )


@pytest.mark.parametrize("cell_m", [[20, 30], np.array([20, 30]), (np.float32(20), np.int64(30))])
def test_a_cell_is_any_sequence_of_two_numbers(cell_m):
    made = Terrain.from_array(HEIGHTS, cell_m)
    assert (made.dx_m, made.dy_m) == (20.0, 30.0)


def test_load(tmp_path):
    np.save(tmp_path / "heights.npy", np.array(HEIGHTS))
    loaded = Terrain.load(tmp_path / "heights.npy", cell_m=(20, 30), fill_voids=True)
    assert (loaded.name, loaded.dx_m, loaded.dy_m) == ("heights", 20.0, 30.0)
    assert loaded.loading == {
        "source": str((tmp_path / "heights.npy").resolve()),
        "fill_voids": True,
        "cell_m": [20, 30],
    }
    assert Terrain.load(tmp_path / "heights.npy", cell_m=20).loading["cell_m"] == [20, 20]
    with pytest.raises(InputError, match=r"^There is no terrain 'nowhere': neither a file nor "):
        Terrain.load("nowhere")


def test_embedded():
    canyon = Terrain.load("canyon")
    assert isinstance(canyon, Terrain)
    assert canyon.loading == {"source": "canyon", "fill_voids": False, "cell_m": None}


def test_marks_of_voids(tmp_path):
    heights = np.add.outer(np.arange(20.0), np.arange(20.0)) + 100
    heights[3, 4], heights[9, 9] = 4321.5, -700.25
    np.save(tmp_path / "a.npy", heights)
    for void, voids in ((4321.5, None), ([4321.5, -700.25], 2), ("none", 0), (np.float64(5), None)):
        if voids is None:
            with pytest.raises(
                InputError, match=r"accept all numbers as heights \(--void none\)\.$"
            ):
                Terrain.load(tmp_path / "a.npy", cell_m=30, void=void)
        else:
            assert Terrain.load(tmp_path / "a.npy", cell_m=30, void=void).voids.sum() == voids
    for void in ("high", [], [np.nan], [1, "a"], {}, b"1", True):
        with pytest.raises(InputError) as caught:
            Terrain.load(tmp_path / "a.npy", cell_m=30, void=void)
        assert str(caught.value) == (
            f"The marks of voids must be numbers of the file or none, not {void!r}."
        )
