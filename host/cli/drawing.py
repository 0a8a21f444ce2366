"""Matplotlib for commands, imported in half the time."""

from __future__ import annotations

import contextlib
from typing import Any


__all__ = ["import_quickly"]


def import_quickly() -> None:
    """Let matplotlib be imported without the tables of properties in its docstrings.

    They and the signatures of their classes take half of its import, and no command shows a
    docstring. Without matplotlib, the drawing itself says so.
    """
    with contextlib.suppress(ImportError):
        from matplotlib import artist

        artist.kwdoc = _no_table
        # Writes docstring and signature of a class. If a version has no such method, only time is
        # lost.
        base: Any = artist.Artist
        base._update_set_signature_and_docstring = _nothing


def _no_table(artist: object) -> str:
    return ""


def _nothing() -> None:
    """Leave docstring and signature of a class as they are."""
