"""The formats, one row each; options, help, the desk and the documents are generated from them.

A format is a file of this folder with one or more of these functions:

``write(track) -> bytes``
    Returns the content of a file for a :class:`pathgene.host.formats.track.Track`.
``recognises(content) -> bool`` and ``features(content) -> iterable of Read``
    Tell whether a :class:`pathgene.host.formats.content.Content` is of this format, and yield its
    areas, in degrees and without any terrain; see :mod:`pathgene.host.formats.features`.
``read_path(file, terrain) -> ndarray``
    Returns the waypoints in a file, (n, 3) float64 metres.
``holds_mission(content) -> bool`` and ``mission(content) -> MissionFile``
    Tell whether a content is of this format, and return the mission in it, in degrees and without
    any terrain; see :mod:`pathgene.host.formats.mission_items`.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from pathgene.host.errors import InputError
from pathgene.host.suggestion import did_you_mean


if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from pathgene.host.formats.content import Content
    from pathgene.host.formats.features import Read
    from pathgene.host.formats.mission_items import Entry, MissionFile
    from pathgene.host.formats.track import Track
    from pathgene.host.terrain import Terrain

__all__ = [
    "FORMATS",
    "Format",
    "changed_mission",
    "changed_name",
    "check_formats",
    "choices",
    "extra_names",
    "files",
    "mission_files",
    "mission_in",
    "mission_suffixes",
    "needs_flight_plan",
    "parse_formats",
    "read_features",
    "read_mission",
    "read_path",
    "usual",
    "write",
    "zone_files",
    "zone_suffixes",
]


@dataclass(frozen=True)
class Format:
    """A row.

    Parameters
    ----------
    name : str
        Name in ``--write``, and name of the module in this folder.
    readers : str
        Programs that read the written file, for help and documents.
    file : str
        Name of the written file; empty for a format that is only read.
    usual : bool
        ``pathgene export`` writes it if no option names the formats.
    placed : bool
        The written file needs a terrain with a place on Earth.
    flown : bool
        The written file needs the flight plan of an autopilot.
    button : str
        Text of the desk's button that downloads the file; empty for none.
    zones : str
        Name of the source of zones, for help; empty for a format without zones.
    suffixes : tuple of str
        Suffixes of files that the desk opens as zones.
    path_suffix : str
        Suffix of files of this format that hold a path; empty for none, ``*`` for any other.
    missions : str
        Name of the source of missions, for help; empty for a format without missions.
    """

    name: str
    readers: str = ""
    file: str = ""
    usual: bool = False
    placed: bool = True
    flown: bool = False
    button: str = ""
    zones: str = ""
    suffixes: tuple[str, ...] = ()
    path_suffix: str = ""
    missions: str = ""

    @property
    def module(self) -> Any:
        """The file of the format, imported when it is used."""
        return importlib.import_module(f"pathgene.host.formats.{self.name}")


#: The rows. A file of zones gets the first format that recognises it, so a format that accepts any
#: XML or any JSON comes after more specific formats.
FORMATS = (
    Format(
        "plan",
        "QGroundControl, MAVSDK",
        "path.plan",
        usual=True,
        flown=True,
        button="QGroundControl",
        zones="the fences of a .plan",
        suffixes=(".plan",),
        missions=".plan",
    ),
    Format(
        "waypoints",
        "Mission Planner, MAVProxy, QGroundControl",
        "path.waypoints",
        usual=True,
        flown=True,
        zones="the fences of a .waypoints",
        suffixes=(".waypoints",),
        missions=".waypoints",
    ),
    Format("fen", zones="a .fen", suffixes=(".fen",)),
    Format("openair", zones="OpenAir", suffixes=(".openair", ".txt")),
    Format("ed269", zones="ED-269"),
    Format("ed318", zones="ED-318"),
    Format("openaip", zones="openAIP"),
    Format("inav", zones="INAV"),
    Format("faa", zones="FAA"),
    Format("kmz", zones="KMZ", suffixes=(".kmz",)),
    Format(
        "kml",
        "Google Earth and other viewers",
        "path.kml",
        usual=True,
        button="KML",
        zones="KML",
        suffixes=(".kml",),
        missions="a line of KML",
    ),
    Format("gpx", missions="a line of GPX"),
    Format(
        "geojson",
        "geographic information systems",
        "path.geojson",
        placed=False,
        zones="GeoJSON",
        suffixes=(".geojson", ".json", ".geojsonl", ".geojsons"),
        path_suffix="*",
    ),
    Format("html", "any browser", "path.html", placed=False, button="Web page"),
    Format("csv", path_suffix=".csv", missions="CSV in degrees"),
)


# Suffixes of files that hold no path but a mission, and suffixes of files that may hold one.
_ONLY_MISSIONS = (".plan", ".waypoints", ".kml", ".gpx")
_MISSIONS = (*_ONLY_MISSIONS, ".txt", ".csv")


def files() -> Mapping[str, str]:
    """Return the names of the written files by the names of their formats."""
    return MappingProxyType({row.name: row.file for row in FORMATS if row.file})


def usual() -> str:
    """Return the default formats of ``pathgene export`` in the syntax of ``--write``."""
    return ",".join(row.name for row in FORMATS if row.usual)


def choices() -> str:
    """Return the written formats with their readers, for the help of ``--write``."""
    return _joined([f"{row.name} ({row.readers})" for row in FORMATS if row.file], "and")


def extra_names() -> str:
    """Return the names of the formats that a run writes on request; it always has path.geojson."""
    return _joined([name for name in files() if name != "geojson"], "and")


def zone_files() -> str:
    """Return the sources of zones, for help and documents."""
    return _joined([row.zones for row in reversed(FORMATS) if row.zones], "or")


def zone_suffixes() -> tuple[str, ...]:
    """Return the suffixes of files that the desk opens as zones."""
    return tuple(suffix for row in FORMATS for suffix in row.suffixes)


def parse_formats(text: str) -> tuple[str, ...]:
    """Return the formats of a list like ``plan,kml``, each once.

    Raises
    ------
    InputError
        If the list is empty or names an unknown format.
    """
    formats = tuple(dict.fromkeys(name.strip() for name in text.split(",")))
    for name in formats:
        if name not in files():
            raise InputError(
                f"There is no file format {name!r}{did_you_mean(name, files())}; give some of "
                f"{', '.join(files())} (--write)."
            )
    return formats


def check_formats(formats: Sequence[str], terrain: Terrain) -> None:
    """Refuse formats that need positions which a terrain lacks; call it before planning the path.

    Raises
    ------
    InputError
        If the terrain has no place on Earth and a format needs one.
    """
    from pathgene.host.formats.places import check_place

    if any(row.placed for row in FORMATS if row.name in formats):
        check_place(terrain)


def needs_flight_plan(formats: Sequence[str]) -> bool:
    """Return whether one of the formats needs the flight plan of an autopilot."""
    return any(row.flown for row in FORMATS if row.name in formats)


def write(track: Track, formats: Sequence[str]) -> dict[str, bytes]:
    """Return the files of a track in some formats: contents by file name."""
    rows = {row.name: row for row in FORMATS if row.file}
    return {rows[name].file: rows[name].module.write(track) for name in formats}


def read_features(path: str | Path) -> tuple[str, Iterable[Read]]:
    """Return the name of the format of a file of zones, as for help, and its features.

    Raises
    ------
    InputError
        If the file cannot be read, or no format recognises it. The features raise it too, if
        nothing can be read from the file.
    """
    from pathgene.host.formats.content import read_content

    content = read_content(path)
    if content.is_empty:
        raise InputError(f"No-fly file {str(path)!r} is empty; give {zone_files()}.")
    rows = (row for row in FORMATS if row.zones)
    found = next((row for row in rows if row.module.recognises(content)), None)
    if found is None:
        kind = content.looks_like
        why = f"looks like {kind}" if kind else "is in no format that is known"
        if kind == "JSON":
            why = f"is not JSON: {content.json_error}"
        raise InputError(f"No-fly file {str(path)!r} {why}; give {zone_files()}.")
    return found.zones, found.module.features(content)


def mission_files() -> str:
    """Return the sources of missions, for help and documents."""
    return _joined([row.missions for row in FORMATS if row.missions], "or")


def mission_suffixes() -> tuple[str, ...]:
    """Return the suffixes of files that the desk opens as missions, if one is in them."""
    return _MISSIONS


def read_mission(file: Path) -> MissionFile | None:
    """Return the mission in a file, or None if the file is of no format that has missions.

    Raises
    ------
    InputError
        If it is of such a format, and no mission can be read from it.
    OSError
        If the system refuses to read it.
    """
    from pathgene.host.inputs import read_bytes

    try:
        return mission_in(read_bytes(file), file.name)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None


def mission_in(source: bytes, name: str) -> MissionFile | None:
    """Return the mission in the bytes of a file with a name; see :func:`read_mission`."""
    from pathgene.host.formats.content import Content

    content = Content(source, name)
    rows = (row for row in FORMATS if row.missions)
    found = next((row for row in rows if row.module.holds_mission(content)), None)
    suffix = Path(name).suffix.lower()
    if found is None and suffix in _ONLY_MISSIONS:
        raise InputError(
            f"this is not the content of a {suffix} file, or a part of it is missing; save it "
            "again."
        )
    mission: MissionFile | None = None if found is None else found.module.mission(content)
    return mission


def changed_mission(
    source: bytes, name: str, out: str, mission: MissionFile, entries: Sequence[Entry]
) -> bytes:
    """Return the file of a changed mission.

    A ``.plan`` and a list of waypoints are written into the file that was read, so that everything
    else in it stays. Every other mission without fences becomes a new ``.plan``.

    Parameters
    ----------
    source : bytes
        The file that was read.
    name, out : str
        Names of the file that was read, and of the file to be written.
    mission : MissionFile
        The mission after the changes.
    entries : sequence of Entry
        Its items, with the places of their originals.

    Raises
    ------
    InputError
        If such a file cannot be written.
    """
    from pathgene.host.files.output import json_bytes
    from pathgene.host.formats.content import Content
    from pathgene.host.formats.plan_mission import new_plan

    content = Content(source, name)
    row = _row_of(content)
    suffix, own = Path(out).suffix.lower(), Path(name).suffix.lower()
    if hasattr(row.module, "changed") and suffix in (own, row.missions):
        written: bytes = row.module.changed(content, entries, mission.rally)
        return written
    if suffix != ".plan":
        same = f" or {Path(out).with_suffix(own)}" if own in (".waypoints", ".txt") else ""
        raise InputError(
            f"{out}: a mended mission of {name} is written as a .plan; give "
            f"{Path(out).with_suffix('.plan')}{same}."
        )
    if mission.has_fences:
        raise InputError(
            f"{out}: a new .plan would lose the fences of {name}; give "
            f"{Path(out).with_suffix(own)}."
        )
    return json_bytes(new_plan(mission))


def changed_name(source: bytes, name: str) -> str:
    """Return a name for :func:`changed_mission`: of the format that was read, if it is written.

    Parameters
    ----------
    source : bytes
        The file that was read; it holds a mission.
    """
    from pathgene.host.formats.content import Content

    file = Path(name)
    is_kept = hasattr(_row_of(Content(source, name)).module, "changed")
    return f"{file.stem}-mended{file.suffix if is_kept else '.plan'}"


def _row_of(content: Content) -> Format:
    """Return the format of a content that holds a mission."""
    return next(row for row in FORMATS if row.missions and row.module.holds_mission(content))


def read_path(file: Path, terrain: Terrain) -> NDArray[np.float64]:
    """Return the waypoints in a file, (n, 3) float64 metres.

    Raises
    ------
    InputError
        If the file cannot be read, or has no path.
    """
    rows = {row.path_suffix: row for row in FORMATS if row.path_suffix}
    row = rows.get(file.suffix.lower(), rows["*"])
    path: NDArray[np.float64] = row.module.read_path(file, terrain)
    return path


def _joined(texts: Sequence[str], word: str) -> str:
    *most, last = texts
    return f"{', '.join(most)} {word} {last}" if most else last
