"""Digest of the sources that kept results follow from."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path


__all__ = ["digest"]

_ROOT = Path(__file__).resolve().parents[1]
_SUFFIXES = (".py", ".xml", ".toml")


@cache
def digest(*names: str) -> str:
    """Return 16 hexadecimal digits that change with any source under ``names``.

    Parameters
    ----------
    *names : str
        Folders or files, relative to the repository. Of a folder, all Python, XML and TOML files
        count, by name and content.

    Raises
    ------
    FileNotFoundError
        If one of ``names`` does not exist.
    """
    found = hashlib.sha256()
    for file in (file for name in names for file in _files(_ROOT / name)):
        found.update(str(file.relative_to(_ROOT)).encode() + file.read_bytes())
    return found.hexdigest()[:16]


def _files(place: Path) -> list[Path]:
    if not place.is_dir():
        return [place]
    return sorted(file for file in place.rglob("*") if file.suffix in _SUFFIXES)
