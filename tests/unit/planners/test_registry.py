"""The list of planners."""

import subprocess
import sys

import pytest

from pathgene.host.errors import InputError
from pathgene.host.planners import DEFAULT, PLANNERS, make


def test_every_planner_is_made_and_described():
    assert DEFAULT == next(iter(PLANNERS)) == "ga-chip"
    for name, entry in PLANNERS.items():
        assert callable(make(name).plan)
        assert entry.description
        assert entry.paper


def test_own_options_reach_the_planner():
    assert make("ga-pc", max_waypoints=7).max_waypoints == 7
    assert make("ga-fpga", board="sim:", link_mode="recipe").board == "sim:"


def test_unknown_planner():
    with pytest.raises(InputError) as caught:
        make("a-star")
    assert str(caught.value) == (
        f"There is no planner 'a-star'; the planners are {', '.join(PLANNERS)}."
    )


def test_importing_the_list_loads_nothing_heavy():
    heavy = """
import sys, pathgene.host.planners, pathgene.host.cli
print([m for m in ("numpy", "scipy", "numba", "matplotlib", "rasterio", "amaranth", "serial")
       if m in sys.modules])
"""
    done = subprocess.run([sys.executable, "-c", heavy], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
