"""Remarks on files that were read, which a command prints about its terrain and zones."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any


__all__ = ["Grade", "Reading", "Remark"]


class Grade(StrEnum):
    """Weight of a remark; a third grade, the refusal, is an :class:`InputError`."""

    NOTE = "note"
    WARNING = "warning"


@dataclass(frozen=True)
class Remark:
    """A sentence about a file."""

    grade: Grade
    text: str

    def to_dict(self) -> dict[str, str]:
        """The remark as in ``summary.json``."""
        return {"grade": str(self.grade), "text": self.text}


@dataclass(frozen=True)
class Reading:
    """Facts that were read from a terrain or from zones, and remarks on them.

    Parameters
    ----------
    facts : mapping
        Values that JSON can hold, by name.
    """

    facts: Mapping[str, Any] = field(default_factory=dict)
    remarks: tuple[Remark, ...] = ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """Texts of the warnings."""
        return tuple(each.text for each in self.remarks if each.grade is Grade.WARNING)

    @staticmethod
    def of(table: Any) -> Reading:
        """Return the reading that :meth:`to_dict` describes.

        Raises
        ------
        ValueError
            If the table does not describe one.
        """
        try:
            facts = dict(table)
            remarks = tuple(
                Remark(Grade(each["grade"]), each["text"]) for each in facts.pop("remarks")
            )
        except (KeyError, TypeError) as error:
            raise ValueError(str(error)) from None
        if not all(isinstance(each.text, str) for each in remarks):
            raise ValueError("a text is needed")
        return Reading(facts, remarks)

    def adding(self, remarks: Iterable[Remark]) -> Reading:
        """Return the reading with more remarks."""
        return Reading(self.facts, (*self.remarks, *remarks))

    def to_dict(self) -> dict[str, Any]:
        """The reading as in ``summary.json``."""
        return {**self.facts, "remarks": [each.to_dict() for each in self.remarks]}
