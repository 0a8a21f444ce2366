"""Terrains: grids of heights, where they come from, and where they lie on Earth.

Importing this package loads neither GDAL nor matplotlib; reading a raster or converting latitude
and longitude loads GDAL.
"""

from pathgene.host.terrain.embedded import names
from pathgene.host.terrain.grid import Terrain
from pathgene.host.terrain.load import info, load


__all__ = ["Terrain", "info", "load", "names"]
