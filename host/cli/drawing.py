"""Matplotlib for commands, imported in half the time."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any, TypeVar


__all__ = ["import_quickly"]

_Method = TypeVar("_Method", bound=Callable[..., Any])


def import_quickly() -> None:
    """Let matplotlib be imported without the tables of properties in its docstrings.

    They, the signatures of their classes and the argument ``data`` of the methods that draw take
    half of its import. No command shows a docstring or draws from a table. Without matplotlib, the
    drawing itself says so.
    """
    with contextlib.suppress(ImportError):
        import matplotlib
        from matplotlib import artist

        artist.kwdoc = _no_table
        # Writes docstring and signature of a class. If a version has no such method, only time is
        # lost.
        base: Any = artist.Artist
        base._update_set_signature_and_docstring = _nothing
        whole: Any = matplotlib
        whole._preprocess_data = _without_data


def _no_table(artist: object) -> str:
    return ""


def _nothing() -> None:
    """Leave docstring and signature of a class as they are."""


def _without_data(method: _Method | None = None, **_: object) -> _Method | Callable[..., Any]:
    """Leave a method as it is; like matplotlib's decorator, with or without arguments."""
    return _same if method is None else method


def _same(method: _Method) -> _Method:
    return method
