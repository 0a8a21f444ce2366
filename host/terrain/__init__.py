"""Terrains: grids of heights, where they come from, and how they look on the chip's map."""

from host.problem.chip_map import ChipMap
from host.terrain.embedded import names
from host.terrain.grid import Terrain
from host.terrain.load import info, load


__all__ = ["ChipMap", "Terrain", "info", "load", "names"]
