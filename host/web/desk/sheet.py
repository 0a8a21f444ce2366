"""The problem of a page: its values, also in the form of a problem file and of a link."""

from __future__ import annotations

import base64
import binascii
import copy
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pathgene.host.errors import InputError
from pathgene.host.mission.build import (
    aircraft_of,
    end_of,
    mission_of,
    planner_of,
    read_zones_of,
    search_of,
)
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.mission.problem_file import parse_problem, problem_text, read_problem
from pathgene.host.options.table import OWN, RULES, options_of
from pathgene.host.planners import DEFAULT, PLANNERS, asks_hardware
from pathgene.host.problem import aircraft
from pathgene.host.problem.ends import place
from pathgene.host.problem.zones import ReadZones, Zone
from pathgene.host.remarks import Reading
from pathgene.host.terrain import Terrain, embedded
from pathgene.host.terrain.stated import STATEMENTS
from pathgene.host.web.desk.boards import require_board
from pathgene.host.web.desk.misread import Misread
from pathgene.host.web.desk.terrains import Terrains


if TYPE_CHECKING:
    from pathgene.host.mission.foreign.judge import FlightProblem

__all__ = ["Sheet", "zone_table"]

#: Maximum bytes of a problem as text: about ten thousand corners.
MOST_BYTES = 1_000_000

# Start and goal on a new terrain: distance from two corners as a share of its sides, and height
# above ground.
_END_SHARE, _END_HEIGHT_M = 0.1, 100.0
# Decimals of positions from a mouse: decimetres.
_DECIMALS = 1
# The desk decides these itself.
_OUTPUT = tuple(option.name for option in options_of("output"))
# The values of the planner, which say how a problem is solved.
_PLANNER = frozenset(option.name for option in options_of("planning", "search", "own"))


# Options on the ends of a path, which a mission has itself.
_OF_ENDS = ("start_heading", "goal_heading")

# Options that belong to a terrain, not to the next one.
_OF_TERRAIN = ("terrain", "fill_voids", "origin", *STATEMENTS, "via", "zones", "zones_read")


class Sheet:
    """The problem of a page.

    Its values have the names in :data:`pathgene.host.options.table.OPTIONS` and a uniform form: the
    terrain by its name on the desk, points in metres of the terrain's frame, zones as tables of a
    circle or a polygon. A value at its default is left out. A method that raises changes nothing.

    Parameters
    ----------
    board : str, optional
        The board of the problem file that the user named when starting the desk, the only such
        board that a page may name: see :func:`pathgene.host.web.desk.boards.require_board`.

    Attributes
    ----------
    misread : Misread
        Texts that are not valid values. While there is one, :meth:`mission` fails.
    """

    def __init__(self, terrains: Terrains, board: str | None = None) -> None:
        self._terrains, self.board = terrains, board
        self.values: dict[str, Any] = {}
        self.misread = Misread()
        self.take_terrain(embedded.names()[0])

    @property
    def planner(self) -> str:
        """The planner of the problem."""
        return str(self.values["planner"])

    @property
    def zones(self) -> list[dict[str, Any]]:
        """The zones, as tables of a problem file."""
        zones: list[dict[str, Any]] = self.values.setdefault("zones", [])
        return zones

    def add_zones(self, read: ReadZones) -> None:
        """Add the zones of a file, and keep the report on it for as long as there are zones."""
        self.zones.extend(map(zone_table, read.zones))
        self.values.setdefault("zones_read", []).extend(_reports(read))

    @property
    def via(self) -> list[tuple[float, ...]]:
        """The via points."""
        via: list[tuple[float, ...]] = self.values.setdefault("via", [])
        return via

    def copy(self) -> Sheet:
        """Return a copy of the problem, which is independent of later changes."""
        other = Sheet.__new__(Sheet)
        other._terrains, other.board = self._terrains, self.board
        # Points and rings are replaced and never changed, so they need no copy.
        other.values = {name: _copied(value) for name, value in self.values.items()}
        other.misread = copy.deepcopy(self.misread)
        return other

    def terrain(self) -> Terrain:
        """Return the terrain, or raise as :meth:`Terrains.load` does."""
        return self._terrains.load(self.values)

    def set(self, name: str, value: Any) -> None:
        """Set a value; None restores its default."""
        if value is None or value is False:
            self.values.pop(name, None)
        else:
            self.values[name] = value

    def take_terrain(self, name: str) -> None:
        """Switch to another terrain, with ends near two corners and no zones or via points.

        Raises
        ------
        InputError
            If it cannot be loaded.
        """
        kept = {key: value for key, value in self.values.items() if key not in _OF_TERRAIN}
        new = {**kept, "terrain": name}
        terrain = self._terrains.load(new)
        new.setdefault("planner", DEFAULT)
        for end, share in (("start", _END_SHARE), ("goal", 1 - _END_SHARE)):
            x, y = (round(share * side, 0) for side in (terrain.width_m, terrain.height_m))
            new[end] = (x, y, _END_HEIGHT_M)
        self.values = {**new, "agl": True}
        for kind in ("start", "goal", "via", "zone"):
            self.misread.clear(kind)

    def place(self, name: str, x: float, y: float, number: int = 0) -> None:
        """Move ``start``, ``goal`` or the via point ``number``; its altitude stays."""
        spot = round(x, _DECIMALS), round(y, _DECIMALS)
        if name == "via":
            self.via[number] = (*spot, self.via[number][2])
        else:
            self.values[name] = (*spot, (self.values.get(name) or (0, 0, _END_HEIGHT_M))[2])

        for part in range(len(spot)):
            self.misread.clear(name, *([number] if name == "via" else []), part)

    def reshape(self, number: int, shape: Mapping[str, Any]) -> None:
        """Give a zone a new shape."""
        self.zones[number].update(shape)
        for name in shape:
            self.misread.clear("zone", number, name)

    def remove_via(self, number: int) -> None:
        """Remove a via point."""
        del self.via[number]
        self.misread.removed("via", number)

    def remove_zone(self, number: int) -> None:
        """Remove a zone."""
        del self.zones[number]
        if not self.zones:
            self.values.pop("zones_read", None)
        self.misread.removed("zone", number)

    def add_via(self, x: float, y: float) -> None:
        """Add a via point as the last one, as high as the previous point."""
        before = self.via[-1] if self.via else self.values.get("start") or (0, 0, _END_HEIGHT_M)
        self.via.append((round(x, _DECIMALS), round(y, _DECIMALS), before[2]))

    def mission(self) -> MissionProblem:
        """Return the mission that the values describe.

        Raises
        ------
        InputError
            If a value is bad or missing, a page may not use the board, or a text is not a valid
            value.
        """
        if (sentence := self.misread.sentence(self._without_field())) is not None:
            raise InputError(sentence)
        self.require_board(self.values.get("board"))
        search_of(self._effective())
        return mission_of(self._effective(), self.terrain())

    def flight_problem(self) -> FlightProblem:
        """Return the conditions by which a mission of any ground station is judged.

        Raises
        ------
        InputError
            If a value is bad, ``as_paper`` is set, or a text is not a valid value.
        """
        from pathgene.host.mission.foreign.conditions import flight_problem_of

        values = self.flight_values()
        terrain = self.terrain()
        return flight_problem_of(values, terrain, read_zones_of(values, terrain).zones)

    def flight_values(self) -> dict[str, Any]:
        """Return the values by which a mission is judged, in the form of :meth:`task`.

        Raises
        ------
        InputError
            As :meth:`flight_problem`, or if the terrain is not on the desk.
        """
        if (sentence := self.misread.sentence(self._without_field())) is not None:
            raise InputError(sentence)
        if self.values.get("as_paper"):
            raise InputError("A mission is judged by the rules; switch off as paper.")
        values = {**self._effective(), **self._terrains.task(str(self.values.get("terrain")))}
        return {name: value for name, value in values.items() if name not in _OF_ENDS}

    def task(self) -> dict[str, Any]:
        """Return the values for a planner, which loads the terrain itself.

        Raises
        ------
        InputError
            If the terrain is not on the desk, or a page may not use the board.
        """
        self.require_board(self.values.get("board"))
        return {**self._effective(), **self._terrains.task(str(self.values.get("terrain")))}

    def require_board(self, board: str | None) -> None:
        """Check a board that the page names; see ``require_board``."""
        require_board(board, self.board)

    def statement(self) -> str | None:
        """Return the problem without its planner as text; None while a text is not a valid value.

        A plan belongs to the displayed problem if the two statements are equal.
        """
        if self.misread.sentence(self._without_field()) is not None:
            return None
        values = {name: value for name, value in self._effective().items() if name not in _PLANNER}
        return problem_text(values, Path(), "problem.toml")

    def text(self) -> str:
        """Return the text of a problem file; a terrain file is expected next to it."""
        return problem_text(self._effective(), Path(), "problem.toml")

    def link(self) -> str:
        """Return the problem as the fragment of a link, without ``#``."""
        packed = zlib.compress(self.text().encode(), 9)
        return base64.urlsafe_b64encode(packed).decode().rstrip("=")

    def open_link(self, fragment: str) -> None:
        """Open the problem of a :meth:`link`.

        Raises
        ------
        InputError
            If it is not a problem, or as for :meth:`open_text`.
        """
        try:
            packed = base64.b64decode(fragment + "=" * (-len(fragment) % 4), "-_", validate=True)
            unpacking = zlib.decompressobj()
            content = unpacking.decompress(packed, MOST_BYTES)
            if not unpacking.eof:
                raise ValueError("cut off, or too long")
            text = content.decode()
        except (ValueError, binascii.Error, zlib.error):
            raise InputError("The link holds no whole problem; copy all of it.") from None
        self.open_text(text)

    def open_text(self, text: str) -> None:
        """Open the problem in the text of a problem file, which must not name a local file.

        Raises
        ------
        InputError
            If it is not a problem file, names a file, a terrain that is not on the desk or a board
            that a page may not name, or a zone or the aircraft is bad.
        """
        values = self._parsed(text)
        self.require_board(values.get("board"))
        self._take(values)

    def open_saved(self, text: str) -> str | None:
        """Open the problem of a saved plan.

        Returns
        -------
        str or None
            A sentence about its board if it is left out because a page may not name it.

        Raises
        ------
        InputError
            As :meth:`open_text`, except for the board.
        """
        values, sentence = self._parsed(text), None
        try:
            self.require_board(values.get("board"))
        except InputError as error:
            sentence = f"The board of the plan is left out. {error}"
            del values["board"]
        self._take(values)
        return sentence

    def _parsed(self, text: str) -> dict[str, Any]:
        """Return the values of a problem file that must not name a local file."""
        values = dict(parse_problem(text, Path()))
        for zone in values.get("zones") or ():
            if "file" in zone:
                raise InputError(
                    f"The problem names a file of zones, {zone['file']!r}; leave it out, and open "
                    "that file after the problem."
                )
        uav = values.get("uav")
        if isinstance(uav, str) and uav not in aircraft.names():
            raise InputError(
                f"The problem names a file of an aircraft, {uav!r}; leave it out, and open that "
                "file after the problem."
            )
        name = values.get("terrain")
        if name is not None and name not in embedded.names():
            values["terrain"] = Path(name).name
        return values

    def open_file(self, file: Path) -> None:
        """Open a problem file of this machine, with the files that it names.

        Raises
        ------
        InputError
            If the file, or a file that it names, is bad.
        """
        values = read_problem(file)
        name = values.get("terrain")
        if name is not None and name not in embedded.names():
            values["terrain"] = self._terrains.add_file(Path(name))
        self._take(values)
        self.board = self.values.get("board")

    def _take(self, values: Mapping[str, Any]) -> None:
        """Replace the values by a problem file's values, converted to the form of this class."""
        taken = {
            name: value
            for name, value in values.items()
            if name not in (*_OUTPUT, "start_geo", "goal_geo", "via_geo", "nofly")
            and value is not None
        }
        taken.setdefault("terrain", embedded.names()[0])
        terrain = self._terrains.load(taken)
        read = read_zones_of(values, terrain)
        taken["zones"] = [zone_table(zone) for zone in read.zones]
        if reports := _reports(read):
            taken["zones_read"] = reports
        for end in ("start", "goal"):
            if (point := end_of(values, end, terrain)) is not None:
                taken[end] = tuple(point)
        taken["via"] = [tuple(point) for point in values.get("via") or ()]
        for number, (latitude, longitude, z) in enumerate(values.get("via_geo") or (), start=1):
            spot = place(f"via point {number}", latitude, longitude, terrain)
            taken["via"].append((*spot, z))
        uav = taken.get("uav")
        if uav is not None and uav not in aircraft.names():
            taken["uav"] = aircraft_of(taken).to_dict()
        taken["planner"] = _planner(taken)
        if taken["planner"] not in PLANNERS:
            raise InputError(f"There is no planner {taken['planner']!r}.")
        self.values = taken
        self.misread.clear()

    def _effective(self) -> dict[str, Any]:
        """Return the values that have an effect, in the form of the command line."""
        void = self._without_field()
        if self.values.get("as_paper"):
            void |= set(RULES)
        return {name: value for name, value in self.values.items() if name not in void}

    def _without_field(self) -> frozenset[str]:
        """Return the options that the planner does not have."""
        own = PLANNERS[self.planner].options
        return frozenset(name for name in OWN if name not in own)


def _copied(value: Any) -> Any:
    """Return a copy of a value whose lists and tables can be changed independently."""
    if isinstance(value, list):
        return [dict(each) if isinstance(each, dict) else each for each in value]
    return dict(value) if isinstance(value, dict) else value


def zone_table(zone: Zone) -> dict[str, Any]:
    """Return a zone as a table of a problem file."""
    table = zone.to_dict()
    if "radius_m" in table:
        circle = [table.pop(key) for key in ("x", "y", "radius_m")]
        table = {"circle": circle, **table}
    return table


def _reports(read: ReadZones) -> list[tuple[str, Reading]]:
    """Return the name of each file of zones with the report on it; the first has all remarks."""
    reports = []
    remarks = read.reading.remarks
    for facts in read.reading.facts["files"]:
        own = {name: value for name, value in facts.items() if name != "file"}
        reports.append((Path(facts["file"]).name, Reading(own, remarks)))
        remarks = ()
    return reports


def _planner(values: Mapping[str, Any]) -> str:
    """Return the named planner, or the default one without querying hardware."""
    if asks_hardware(values.get("planner"), values.get("board")):
        return DEFAULT
    return planner_of(values)
