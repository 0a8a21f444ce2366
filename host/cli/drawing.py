"""Matplotlib for commands, imported in a third of the time."""

from __future__ import annotations

import contextlib


__all__ = ["import_quickly"]


def import_quickly() -> None:
    """Let matplotlib be imported without the tables of properties in its docstrings.

    They take two thirds of its import, and no command shows a docstring. Without matplotlib, the
    drawing itself says so.
    """
    with contextlib.suppress(ImportError):
        from matplotlib import artist

        artist.kwdoc = _no_table


def _no_table(artist: object) -> str:
    return ""
