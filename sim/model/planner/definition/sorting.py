"""Model of the sorter: its members, and how many of them a new one passes."""

from __future__ import annotations

from bisect import bisect_right


__all__ = ["Sorting"]


class Sorting:
    """Members in the sorter, from the best to the worst; it is empty at first.

    Parameters
    ----------
    capacity : int
        Members inside, at most: one more drops the worst.
    """

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self._inside: list[tuple[int, bool]] = []

    def insert(self, key: int, *, late: bool) -> int:
        """Insert a member and return how many it passes: those worse than it.

        ``late``: it is behind those of its key that are not. Of equals the earlier stays first.
        """
        place = bisect_right(self._inside, (key, late))
        passed = len(self._inside) - place
        self._inside.insert(place, (key, late))
        del self._inside[self._capacity :]
        return passed
