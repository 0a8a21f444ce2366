"""Files that a user gives to the page: problems, zones, aircraft and terrains."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.files.output import output_file
from pathgene.host.formats.registry import zone_suffixes
from pathgene.host.inputs import MOST_TOML_BYTES, parse_toml
from pathgene.host.mission.build import read_zones_of
from pathgene.host.options.table import TABLES
from pathgene.host.problem import aircraft
from pathgene.host.report.reading import sentences
from pathgene.host.web.desk.sheet import Sheet
from pathgene.host.web.desk.terrains import Terrains


__all__ = ["open_upload"]

# Maximum characters of a file's name.
_LONGEST_NAME = 100
# A file is read for itself.
_NO_ZONES: Mapping[str, Any] = {"zones": (), "nofly_circle": (), "zones_read": ()}


def open_upload(sheet: Sheet, terrains: Terrains, name: str, content: bytes) -> list[str]:
    """Open a file whose kind is recognized by its name and content; return a report.

    A problem replaces everything in ``sheet``, a terrain everything except the planner, rules and
    aircraft; zones are added to the existing ones. The sentences are the read report on the
    terrain and the zones; there are none on an aircraft.

    Raises
    ------
    InputError
        If it is not one of these, or is bad; the sheet is then unchanged.
    """
    suffix = Path(name).suffix.lower()
    if suffix == ".toml":
        return _open_toml(sheet, name, content)
    if suffix in zone_suffixes():
        return _open_zones(sheet, name, content)
    sheet.take_terrain(terrains.add_content(name, content, sheet.values))
    return list(sentences({"terrain": sheet.terrain().reading.to_dict(), "zones": {}}))


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


def _open_zones(sheet: Sheet, name: str, content: bytes) -> list[str]:
    terrain = sheet.terrain()
    with tempfile.TemporaryDirectory(prefix="pathgene-") as folder:
        file = Path(folder) / Path(name).name[-_LONGEST_NAME:]
        with output_file(file) as binary:
            binary.write(content)
        try:
            read = read_zones_of({**sheet.values, **_NO_ZONES, "nofly": [str(file)]}, terrain)
        except InputError as error:
            raise InputError(str(error).replace(str(file), name)) from None
    sheet.add_zones(read)
    return list(sentences({"terrain": {}, "zones": read.reading.to_dict()}))
