"""The fields of the form, made from the table of options."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pathgene.host.errors import InputError
from pathgene.host.numeric import parse
from pathgene.host.options.kinds import BOOLEAN, CELL, INTEGER, NUMBER, VOIDS, WATER_LEVEL
from pathgene.host.options.option import Option
from pathgene.host.options.table import OPTIONS, TABLES
from pathgene.host.planners import PLANNERS
from pathgene.host.problem import aircraft


__all__ = ["GROUPS", "ZONE_FIELDS", "Field", "fields_of", "planner_fields"]

Widget = Literal["switch", "choice", "number", "text"]

#: Tables of a problem file that the form shows, each under the name of a panel.
GROUPS = {
    "mission": "Mission",
    "rules": "Rules",
    "planner": "Planner",
    "terrain": "Terrain",
}


@dataclass(frozen=True)
class Field:
    """A field of the form.

    Parameters
    ----------
    option : Option
        Its row in the table of options, with meaning and default.
    widget : str
        Kind of element: ``switch``, ``choice``, ``number``, or ``text``.
    meaning : str
        Its meaning for users, without a full stop.
    """

    option: Option
    widget: Widget
    choices: tuple[str, ...]
    meaning: str

    @property
    def label(self) -> str:
        """Its name on a page."""
        # The name of a planner or of an aircraft, not of a zone.
        named = self.option.key == "name" and self.option.table != "zones"
        return self.option.table if named else self.option.key.replace("_", " ")

    def text_of(self, value: Any) -> str:
        """Return the text of a value in the field; empty for None."""
        if value is None:
            return ""
        if isinstance(value, float):
            return f"{value:.10g}"
        if isinstance(value, tuple | list):
            return ", ".join(f"{part:.10g}" for part in value)
        return str(value)

    def value_of(self, text: Any) -> Any:
        """Return the value of an entered text, or None for an empty one.

        Raises
        ------
        InputError
            If it is not a valid value.
        """
        if text is None or text == "":
            return None
        try:
            return self.option.kind.read(_typed(self.option, text), Path())
        except ValueError:
            raise InputError(
                f"The {self.label} must be {self.option.kind.name}, not {text!r}."
            ) from None


def _typed(option: Option, text: Any) -> Any:
    """Return the TOML value of a text."""
    if not isinstance(text, str):
        return text
    if option.kind is INTEGER:
        return int(text)
    if option.kind is NUMBER:
        return parse(text)
    if option.kind in (WATER_LEVEL, VOIDS) and text == "none":
        return text
    if option.kind is WATER_LEVEL:
        return parse(text)
    if _is_list(option):
        parts = [parse(part) for part in text.replace(";", ",").split(",")]
        return parts[0] if option.kind is CELL and len(parts) == 1 else parts
    return text


def _is_list(option: Option) -> bool:
    return option.kind in (CELL, VOIDS) or option.kind.name.startswith("a list of ")


def _field(option: Option) -> Field:
    widget: Widget = "text"
    if option.kind is BOOLEAN:
        widget = "switch"
    elif option.choices:
        widget = "choice"
    elif option.kind in (NUMBER, INTEGER):
        widget = "number"
    return Field(option, widget, option.choices, option.meaning)


def fields_of(table: str) -> list[Field]:
    """Return the fields of a table of a problem file, without the planners' own options.

    Parameters
    ----------
    table : str
        One of :data:`GROUPS`, or ``aircraft``.
    """
    options = [option for option in OPTIONS if option.table == table and option.desk == "form"]
    if table == "aircraft":
        (option,) = (option for option in options if option.key == "name")
        return [Field(option, "choice", tuple(aircraft.names()), TABLES[table].rstrip("."))]
    return [_field(option) for option in options if option.group != "own"]


def planner_fields(planner: str) -> list[Field]:
    """Return the fields of a planner's own options."""
    own = PLANNERS[planner].options
    return [_field(option) for option in OPTIONS if option.group == "own" and option.name in own]


#: Fields of a zone in addition to its shape.
ZONE_FIELDS = tuple(
    _field(option) for option in OPTIONS if option.table == "zones" and option.desk == "form"
)
