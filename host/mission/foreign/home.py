"""Places of items over a terrain: home, and the surfaces that heights are measured from."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pathgene.host.errors import InputError
from pathgene.host.formats.mission_items import MissionFile, MissionItem
from pathgene.host.mission.foreign.commands import FRAMES, Frame, named, named_frame
from pathgene.host.problem.ends import place as place_in_degrees
from pathgene.host.remarks import Grade, Remark
from pathgene.host.terrain import Terrain


__all__ = ["MOST_M", "SAME_HEIGHT_M", "HomePlace", "Surroundings", "check_size"]

#: A home or landing in the file and the ground of the map may differ by this.
SAME_HEIGHT_M = 10.0
#: Heights and radii beyond this are slips.
MOST_M = 100_000.0
# A line across the antimeridian may count on beyond 180 degrees.
_MOST_DEGREES = 360.0


@dataclass(frozen=True)
class HomePlace:
    """Home in the terrain's frame, with its altitude."""

    x_m: float
    y_m: float
    z_m: float


def check_size(name: str, what: str, metres: float) -> None:
    """Refuse a height or radius that no aircraft flies."""
    if abs(metres) > MOST_M:
        raise InputError(
            f"{name} has {what} of {metres:g} m; the most is {MOST_M:,.0f} m, so mend the number."
        )


class Surroundings:
    """The terrain and home of a mission.

    Parameters
    ----------
    mission : MissionFile
        The mission.
    terrain : Terrain
        The terrain; it has a place on Earth.

    Attributes
    ----------
    remarks : list of Remark
        Sentences on home and on surfaces that heights are measured from.
    used : set of Frame
        Frames of the heights of items.
    """

    def __init__(self, mission: MissionFile, terrain: Terrain) -> None:
        self._mission, self.terrain = mission, terrain
        self.remarks: list[Remark] = []
        self.used: set[Frame] = set()
        self._home: HomePlace | None = None

    @property
    def home(self) -> HomePlace | None:
        """Home, if it is known or was needed."""
        if self._home is None and self._mission.home is not None:
            self._home = self._stated()
        return self._home

    def home_needed(self) -> HomePlace:
        """Return home; without one in the file, the ground below the first place."""
        if self.home is None:
            first = next((item for item in self._mission.items if item.lat is not None), None)
            if first is None or first.lat is None or first.lon is None:
                raise InputError("it has neither home nor an item with a place.")
            name = f"{self._mission.word} {first.number}"
            x, y = self.local(name, first.lat, first.lon)
            z = self._ground(name, x, y)
            self._home = HomePlace(x, y, z)
            text = f"no home; home is taken to be the ground below {name}, at {z:.1f} m."
            self.remarks.append(Remark(Grade.WARNING, text))
        assert self._home is not None
        return self._home

    def place(self, item: MissionItem, name: str) -> tuple[float, float, float]:
        """Return position and altitude of an item.

        Raises
        ------
        InputError
            If it has no place, or its height is unknown.
        """
        if item.lat is None or item.lon is None:
            raise InputError(
                f"{name} ({named(item.command)}) has no place, as its latitude and longitude are 0 "
                "or missing; give it one."
            )
        x, y = self.local(name, item.lat, item.lon)
        return x, y, self.altitude(item, name, x, y)

    def altitude(self, item: MissionItem, name: str, x_m: float, y_m: float) -> float:
        """Return the altitude of an item at a place."""
        frame = FRAMES.get(item.frame)
        if frame is None:
            raise InputError(
                f"{name} has a height in the frame {named_frame(item.frame)}, which cannot be "
                "judged; give it above mean sea level (0), above home (3) or above the ground (10)."
            )
        if item.alt_m is None:
            raise InputError(f"{name} ({named(item.command)}) has no height.")
        check_size(f"{name} ({named(item.command)})", "a height", item.alt_m)
        self.used.add(frame)
        if frame is Frame.HOME:
            return self.home_needed().z_m + item.alt_m
        return item.alt_m + (self._ground(name, x_m, y_m) if frame is Frame.GROUND else 0.0)

    def height_in(self, frame: int, x_m: float, y_m: float, z_m: float) -> float:
        """Return an altitude as a height in the frame of an item; NaN over unknown ground."""
        surface = FRAMES[frame]
        if surface is Frame.AMSL:
            return z_m
        return z_m - (self.home_needed().z_m if surface is Frame.HOME else self.ground(x_m, y_m))

    def ground(self, x_m: float, y_m: float) -> float:
        """Return the height of the ground; NaN over a void and off the map."""
        return self._between(x_m, y_m) if self._is_on_map(x_m, y_m) else math.nan

    def local(self, name: str, lat: float, lon: float) -> tuple[float, float]:
        """Return the position of a place in degrees; it may lie off the map."""
        if abs(lon) > _MOST_DEGREES:
            raise InputError(
                f"{name} has the longitude {lon:g}, which must be from -180 to 180 degrees."
            )
        return place_in_degrees(name, lat, lon, self.terrain)

    def _stated(self) -> HomePlace:
        """Return home as the file states it, or with the height of the ground."""
        assert self._mission.home is not None
        lat, lon, stated = self._mission.home
        check_size("home", "an altitude", stated or 0.0)
        x, y = self.local("home", lat, lon)
        ground = self.ground(x, y)
        if math.isnan(ground):
            if stated is None:
                raise InputError("home has no altitude, and lies off the map or over a void.")
            text = (
                f"home lies off the map or over a void, so its altitude of {stated:g} m is not "
                "compared with the ground; heights above home are judged from it."
            )
            self.remarks.append(Remark(Grade.WARNING, text))
            return HomePlace(x, y, stated)
        if stated is not None and abs(stated - ground) <= SAME_HEIGHT_M:
            return HomePlace(x, y, stated)
        # Files that nobody placed have 0.
        lower = ground if not stated else min(stated, ground)
        what = "no altitude" if stated is None else f"the altitude {stated:g} m"
        text = (
            f"home has {what}, and the ground there is at {ground:.1f} m; heights above home are "
            f"judged from {lower:.1f} m."
        )
        grade = Grade.NOTE if stated is None else Grade.WARNING
        self.remarks.append(Remark(grade, text))
        return HomePlace(x, y, lower)

    def _ground(self, name: str, x_m: float, y_m: float) -> float:
        """Return the height of the ground, which must be known."""
        height = self.ground(x_m, y_m)
        if math.isnan(height):
            raise InputError(
                f"{name} has a height above the ground, which is unknown there: it lies "
                f"{'over a void of' if self._is_on_map(x_m, y_m) else 'off'} the map."
            )
        return height

    def _is_on_map(self, x_m: float, y_m: float) -> bool:
        return 0 <= x_m <= self.terrain.width_m and 0 <= y_m <= self.terrain.height_m

    def _between(self, x_m: float, y_m: float) -> float:
        """Return the height between the four nodes around a place on the map."""
        terrain = self.terrain
        rows, columns = terrain.shape
        across, up = x_m / terrain.dx_m, y_m / terrain.dy_m
        column, row = min(int(across), columns - 2), min(int(up), rows - 2)
        east, north = across - column, up - row
        corners = terrain.elevation[row : row + 2, column : column + 2]
        weights = np.outer((1 - north, north), (1 - east, east))
        return float(np.where(weights > 0, corners * weights, 0.0).sum())
