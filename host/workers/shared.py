"""Tasks that share large objects, which are sent to a process only once."""

from __future__ import annotations

import io
import pickle
from collections.abc import Sequence
from typing import Any


__all__ = ["packed", "unpacked"]


def packed(task: object, shared: Sequence[object]) -> bytes:
    """Return a task as bytes, with the numbers of ``shared`` objects instead of the objects."""
    file = io.BytesIO()
    _Pickler(file, shared).dump(task)
    return file.getvalue()


def unpacked(content: bytes, shared: Sequence[object]) -> Any:
    """Return a task from :func:`packed`; ``shared`` are the same objects or their copies."""
    return _Unpickler(io.BytesIO(content), shared).load()


class _Pickler(pickle.Pickler):
    def __init__(self, file: io.BytesIO, shared: Sequence[object]) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._numbers = {id(each): number for number, each in enumerate(shared)}

    def persistent_id(self, obj: object) -> int | None:
        return self._numbers.get(id(obj))


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, shared: Sequence[object]) -> None:
        super().__init__(file)
        self._shared = shared

    def persistent_load(self, pid: int) -> object:
        return self._shared[pid]
