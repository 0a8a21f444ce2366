"""Texts in the fields of a page that are not valid values."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass


__all__ = ["Misread", "Place", "Wrong"]

#: Place of a field on a page: ``("form", name)``; ``("start", part)``, ``("goal", part)``;
#: ``("via", number, part)``; ``("zone", number, name)``, with a part if there are several.
Place = tuple[str | int, ...]


@dataclass(frozen=True)
class Wrong:
    """A text that is not a valid value."""

    text: str
    sentence: str


class Misread:
    """The texts of a page that are not valid values, each kept until its field changes."""

    def __init__(self) -> None:
        self._wrong: dict[Place, Wrong] = {}

    def at(self, place: Place) -> Wrong | None:
        """Return the text at a place if it is not a valid value."""
        return self._wrong.get(place)

    def note(self, place: Place, wrong: Wrong) -> None:
        """Note a text."""
        self._wrong[place] = wrong

    def clear(self, *place: str | int) -> None:
        """Forget the texts of all places that begin with ``place``: of all, if it is empty."""
        for each in [each for each in self._wrong if each[: len(place)] == place]:
            del self._wrong[each]

    def removed(self, kind: str, number: int) -> None:
        """Forget a via point or a zone; the numbers of later ones fall by 1."""
        self.clear(kind, number)
        for each in sorted((each for each in self._wrong if each[0] == kind), key=str):
            if isinstance(each[1], int) and each[1] > number:
                self._wrong[(kind, each[1] - 1, *each[2:])] = self._wrong.pop(each)

    def sentence(self, void: Collection[str]) -> str | None:
        """Return a sentence about the first of the texts, or None.

        Parameters
        ----------
        void : collection of str
            Names of fields of the form that the page does not show.
        """
        for place, wrong in self._wrong.items():
            if place[0] == "form":
                if place[1] in void:
                    continue
                return wrong.sentence
            number = f" {int(place[1]) + 1}" if place[0] in ("via", "zone") else ""
            return f"{str(place[0]).capitalize()}{number}: {wrong.sentence}"
        return None
