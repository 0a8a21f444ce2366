"""The formats, one row each; options, help, the desk and the documents are generated from them.

A format is a file of this folder with one or more of these functions:

``write(track) -> bytes``
    Returns the content of a file for a :class:`pathgene.host.formats.track.Track`.
``recognises(content) -> bool`` and ``features(content) -> iterable of Read``
    Tell whether a :class:`pathgene.host.formats.content.Content` is of this format, and yield its
    areas, in degrees and without any terrain; see :mod:`pathgene.host.formats.features`.
``read_path(file, terrain) -> ndarray``
    Returns the waypoints in a file, (n, 3) float64 metres.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from pathgene.host.errors import InputError


if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from pathgene.host.formats.features import Read
    from pathgene.host.formats.track import Track
    from pathgene.host.terrain import Terrain

__all__ = [
    "FORMATS",
    "Format",
    "check_formats",
    "choices",
    "extra_names",
    "files",
    "needs_flight_plan",
    "parse_formats",
    "read_features",
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
    ),
    Format(
        "waypoints",
        "Mission Planner, MAVProxy, QGroundControl",
        "path.waypoints",
        usual=True,
        flown=True,
        zones="the fences of a .waypoints",
        suffixes=(".waypoints",),
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
    ),
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
    Format("csv", path_suffix=".csv"),
)


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
                f"There is no file format {name!r}; give some of {', '.join(files())} (--write)."
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
