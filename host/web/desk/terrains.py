"""The terrains of a desk: the embedded ones, and files that were added to it."""

from __future__ import annotations

import contextlib
import hashlib
import re
import threading
from collections import OrderedDict
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.files.output import output_file, prepare_directory
from pathgene.host.files.replacement import replace_files
from pathgene.host.mission.build import terrain_of
from pathgene.host.terrain import Terrain, embedded
from pathgene.host.terrain.stated import STATEMENTS


__all__ = ["Terrains"]

# Values of a problem that decide how its terrain is read.
_OWN = ("fill_voids", "cell", "origin", *STATEMENTS)
# Terrains kept in memory, enough for a few tabs.
_KEPT = 4
# Files that GDAL writes next to a raster.
_HIDDEN = re.compile(r"^\.|\.aux\.xml$")
_DIGEST_LENGTH = 8


class Terrains:
    """Terrains, by their names in problems on a desk.

    A problem from a link must not name files of this machine, so a name stands for a terrain of
    ``pathgene terrain list``, a file in a folder of the desk, or a file that the user named when
    starting the desk.

    Parameters
    ----------
    directory : Path
        Folder of the files that are added to the desk; it need not exist.
    max_cells : int, optional
        Maximum cells of a terrain; see :func:`pathgene.host.terrain.load`.
    """

    def __init__(self, directory: Path, max_cells: int | None = None) -> None:
        self._directory, self.max_cells = directory, max_cells
        self._files: dict[str, Path] = {}
        self._trusted: set[str] = set()
        self._loaded: OrderedDict[tuple[Any, ...], Terrain] = OrderedDict()
        self._lock = threading.Lock()
        with contextlib.suppress(OSError):
            for file in sorted(directory.iterdir()):
                if file.is_file() and not _HIDDEN.search(file.name):
                    self._files[file.name] = file

    @property
    def names(self) -> list[str]:
        """All names, embedded terrains first."""
        return [*embedded.names(), *self._files]

    def add_file(self, file: Path) -> str:
        """Add a file that the user named; return its name here."""
        resolved = file.resolve()
        for name, known in self._files.items():
            if known.resolve() == resolved:
                return name
        name = _unlike(file.name, self._files)
        self._files[name] = file
        self._trusted.add(name)
        return name

    def add_content(self, name: str, content: bytes, values: Mapping[str, Any]) -> str:
        """Keep a file from a browser if it is a terrain; return its name here.

        Equal content gets the same name, so that a link still finds it.

        Parameters
        ----------
        values : mapping
            Values of the problem that say how to load it, for example an array without cell sides.

        Raises
        ------
        InputError
            If it is not a terrain, names other files, has too many cells, or cannot be kept.
        """
        digest = hashlib.sha256(content).hexdigest()[:_DIGEST_LENGTH]
        plain = Path(re.sub(r"[^\w.-]+", "-", Path(name).name).strip(".-")[-80:] or "terrain")
        suffix = plain.suffix.lower()
        # GDAL reads the place of an SRTM tile from its name, up to the first dot.
        kept = f"{plain.stem}{'.' if suffix == '.hgt' else '-'}{digest}{suffix}"
        if kept in self._files:
            return kept
        prepare_directory(self._directory)
        file = self._directory / kept
        with output_file(file) as binary:
            binary.write(content)
        self._files[kept] = file
        try:
            self.load({**values, "terrain": kept})
        except InputError as error:
            del self._files[kept]
            with contextlib.suppress(OSError):
                replace_files(self._directory, {}, gone=(kept,))
            raise InputError(str(error).replace(str(file), Path(name).name)) from None
        return kept

    def source_of(self, name: str) -> str:
        """Return the name of an embedded terrain, or the path of a file, for a problem file.

        Raises
        ------
        InputError
            If the desk has no such terrain.
        """
        if name in embedded.names():
            return name
        if name not in self._files:
            raise InputError(
                f"The terrain {name!r} is not on this desk; open its file here, then the problem "
                "again."
            )
        return str(self._files[name])

    def task(self, name: str) -> dict[str, Any]:
        """Return the values with which another process loads a terrain.

        Content from a browser must not name files of this machine, as a virtual raster does.

        Raises
        ------
        InputError
            If the desk has no such terrain.
        """
        return {
            "terrain": self.source_of(name),
            "max_cells": self.max_cells,
            "self_contained": name in self._files and name not in self._trusted,
        }

    def load(self, values: Mapping[str, Any]) -> Terrain:
        """Return the terrain of a problem; the last few are kept in memory.

        Raises
        ------
        InputError
            If the problem names none, or it cannot be loaded.
        """
        name = values.get("terrain")
        if name is None:
            raise InputError("The problem names no terrain; choose one.")
        source = self.source_of(name)
        own = {key: values.get(key) for key in _OWN}
        place = (source, *own.values())
        with self._lock:
            if place in self._loaded:
                self._loaded.move_to_end(place)
                return self._loaded[place]
        terrain = terrain_of({**own, **self.task(name)})
        with self._lock:
            self._loaded[place] = terrain
            while len(self._loaded) > _KEPT:
                self._loaded.popitem(last=False)
        return terrain


def _unlike(name: str, others: Mapping[str, Any]) -> str:
    """Return a name that no other terrain uses."""
    taken = {*others, *embedded.names()}
    number, candidate = 2, name
    while candidate in taken:
        candidate = f"{Path(name).stem}-{number}{Path(name).suffix}"
        number += 1
    return candidate
