"""Files that a user gives to the page: problems, zones, missions, aircraft and terrains."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.files.output import output_file
from pathgene.host.formats.features import LeftOut
from pathgene.host.formats.kml_lines import LINE
from pathgene.host.formats.mission_items import MissionFile
from pathgene.host.formats.registry import (
    mission_in,
    mission_suffixes,
    read_features,
    zone_suffixes,
)
from pathgene.host.inputs import MOST_TEXT_BYTES, MOST_TOML_BYTES, parse_toml
from pathgene.host.mission.build import read_zones_of
from pathgene.host.mission.foreign.check import check_mission
from pathgene.host.mission.foreign.words import counted
from pathgene.host.options.table import TABLES
from pathgene.host.problem import aircraft
from pathgene.host.problem.zones import ReadZones
from pathgene.host.report.reading import sentences
from pathgene.host.web.desk.opened import OpenMission
from pathgene.host.web.desk.sheet import Sheet, zone_table
from pathgene.host.web.desk.terrains import Terrains


__all__ = ["open_upload"]

# Maximum characters of a file's name.
_LONGEST_NAME = 100
# A file is read for itself.
_NO_ZONES: Mapping[str, Any] = {"zones": (), "nofly_circle": (), "zones_read": ()}
_OUTLINE = (
    "its line ends where it begins, around an area; move the last point if it is to be flown."
)


def open_upload(
    sheet: Sheet, terrains: Terrains, name: str, content: bytes, earlier: OpenMission | None = None
) -> tuple[list[str], OpenMission | None]:
    """Open a file whose kind is recognized by its name and content.

    A problem replaces everything in ``sheet``, a terrain everything except the planner, rules and
    aircraft; zones are added to the existing ones. A file may hold a mission and zones: the zones
    are added, except those that are there already.

    Parameters
    ----------
    earlier : OpenMission, optional
        The mission that another mission replaces, together with its fences.

    Returns
    -------
    list of str, OpenMission or None
        The read report in sentences, none on an aircraft; and the mission in the file.

    Raises
    ------
    InputError
        If it is not one of these, or is bad; the sheet is then unchanged.
    """
    suffix = Path(name).suffix.lower()
    if suffix == ".toml":
        return _open_toml(sheet, name, content), None
    if suffix in mission_suffixes():
        opened = _open_mission(sheet, name, content, earlier)
        if opened is not None:
            return opened
    if suffix in zone_suffixes():
        read = _read_zones(sheet, name, content, is_needed=True)
        assert read is not None
        sheet.add_zones(read)
        return _report(read), None
    sheet.take_terrain(terrains.add_content(name, content, sheet.values))
    return list(sentences({"terrain": sheet.terrain().reading.to_dict(), "zones": {}})), None


def _open_toml(sheet: Sheet, name: str, content: bytes) -> list[str]:
    if len(content) > MOST_TOML_BYTES:
        most = MOST_TOML_BYTES // 1_000_000
        raise InputError(f"{name}: has more than {most} MB, too much for a problem.")
    try:
        text = content.decode()
        tables = parse_toml(text)
    except ValueError as error:
        raise InputError(f"{name}: not valid TOML: {error}.") from None
    if not set(tables) & set(TABLES):
        sheet.set("uav", aircraft.parse(text, name).to_dict())
        return []
    sheet.open_text(text)
    terrain = sheet.terrain()
    zones = read_zones_of(sheet.values, terrain).reading
    return list(sentences({"terrain": terrain.reading.to_dict(), "zones": zones.to_dict()}))


def _open_mission(
    sheet: Sheet, name: str, content: bytes, earlier: OpenMission | None
) -> tuple[list[str], OpenMission | None] | None:
    """Open the mission and the zones in a file, whichever it has; None for another format."""
    if len(content) > MOST_TEXT_BYTES:
        most = MOST_TEXT_BYTES // 1_000_000
        raise InputError(f"{name}: has more than {most} MB, too much for a mission.")
    mission, why = None, ""
    try:
        mission = mission_in(content, name)
        if mission is None:
            return None
    except InputError as error:
        why = str(error)
    # A mission is not opened without its fences.
    is_needed, read = mission is not None and mission.has_fences, None
    if Path(name).suffix.lower() in zone_suffixes():
        read = _read_zones(sheet, name, content, is_needed=is_needed)
    tables = [] if read is None else [zone_table(zone) for zone in read.zones]
    if mission is not None and read is not None and _is_outline(mission):
        mission, why = None, _OUTLINE
    if mission is not None:
        try:
            check_mission(mission, sheet.flight_problem())
        except InputError as error:
            if mission.has_fences:
                # To stay within the fences of a mission elsewhere would forbid the whole map.
                read = None
            mission, why = None, str(error)
    if mission is None:
        if read is None:
            raise InputError(f"{name} cannot be opened as a mission: {why}")
        sheet.add_zones(read)
        return [f"{name}: {counted(len(tables), 'zone')}, no mission: {why}", *_report(read)], None
    said = f"{name}: {mission.kind}, {counted(len(mission.items), mission.word)}"
    report = []
    if read is not None:
        said += f", and {counted(len(tables), 'zone')}"
        report = _report(read)
        pairs = zip(read.zones, tables, strict=True)
        sheet.add_zones(
            replace(read, zones=tuple(zone for zone, table in pairs if table not in sheet.zones))
        )
    opened = OpenMission(name, content, mission, tables if mission.has_fences else [])
    for table in () if earlier is None else earlier.fences:
        if table not in opened.fences and table in sheet.zones:
            sheet.remove_zone(sheet.zones.index(table))
    return [f"{said}.", *report], opened


def _is_outline(mission: MissionFile) -> bool:
    """Return whether a line of KML is closed, which is an area for the reader of zones."""
    ends = [(item.lat, item.lon) for item in (mission.items[0], mission.items[-1])]
    return mission.kind == LINE and len(mission.items) > 3 and ends[0] == ends[1]


def _read_zones(sheet: Sheet, name: str, content: bytes, *, is_needed: bool) -> ReadZones | None:
    """Return the zones in a file, or None if it has no areas and none ``is_needed``."""
    terrain = sheet.terrain()
    with tempfile.TemporaryDirectory(prefix="pathgene-") as folder:
        file = Path(folder) / Path(name).name[-_LONGEST_NAME:]
        with output_file(file) as binary:
            binary.write(content)
        if not is_needed and not _has_areas(file):
            return None
        try:
            return read_zones_of({**sheet.values, **_NO_ZONES, "nofly": [str(file)]}, terrain)
        except InputError as error:
            raise InputError(str(error).replace(str(file), name)) from None


def _has_areas(file: Path) -> bool:
    """Return whether there are areas in a file, bad ones included."""
    try:
        _, features = read_features(file)
        return any(not isinstance(each, LeftOut) for each in features)
    except InputError:
        return False


def _report(read: ReadZones) -> list[str]:
    return list(sentences({"terrain": {}, "zones": read.reading.to_dict()}))
