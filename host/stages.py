"""Stages of long work by name: planners announce them, and a command shows them."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from contextvars import ContextVar


__all__ = ["Watcher", "current_part", "part", "stage", "watched_by"]

#: Receives the name of a stage, and the share of it that is done, 0..1, if known.
Watcher = Callable[[str, float | None], object]

_WATCHER: ContextVar[Watcher | None] = ContextVar("watcher", default=None)
_PART: ContextVar[str] = ContextVar("part", default="")


def stage(name: str, share: float | None = None) -> None:
    """Announce the stage that begins, or how much of the current stage is done."""
    watcher = _WATCHER.get()
    if watcher is not None:
        watcher(name, share)


@contextlib.contextmanager
def part(name: str) -> Iterator[None]:
    """Name the part of the work to which the stages of the block belong, such as a leg."""
    before = _PART.set(name)
    try:
        yield
    finally:
        _PART.reset(before)


def current_part() -> str:
    """Return the name of the current part, or an empty text."""
    return _PART.get()


@contextlib.contextmanager
def watched_by(watcher: Watcher) -> Iterator[None]:
    """Pass the stages of the block, in this thread, to ``watcher``."""
    before = _WATCHER.set(watcher)
    try:
        yield
    finally:
        _WATCHER.reset(before)
