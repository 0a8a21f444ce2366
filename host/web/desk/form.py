"""The fields of the form, made from the keys of a problem file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pathgene.host.errors import InputError
from pathgene.host.mission.keys import KEYS, TABLES, Key
from pathgene.host.mission.values import BOOLEAN, CELL, INTEGER, NUMBER
from pathgene.host.numeric import parse
from pathgene.host.planners import OPTIONS, PLANNERS
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

# What has a place of its own on the page: the map and its lists.
_ELSEWHERE = {"terrain", "start", "goal", "via", "start_geo", "goal_geo", "via_geo"}


@dataclass(frozen=True)
class Field:
    """A field of the form.

    Parameters
    ----------
    key : Key
        Its key in a problem file, with meaning and default.
    widget : str
        How it is shown: ``switch``, ``choice``, ``number``, or ``text``.
    choices : tuple of str
        Of a choice, all values.
    meaning : str
        Its meaning for users, without a full stop.
    """

    key: Key
    widget: Widget
    choices: tuple[str, ...]
    meaning: str

    @property
    def label(self) -> str:
        """Its name as a page shows it."""
        # The name of a planner or of an aircraft, not of a zone.
        named = self.key.name == "name" and self.key.table != "zones"
        return self.key.table if named else self.key.name.replace("_", " ")

    def text_of(self, value: Any) -> str:
        """Return a value as the field shows it; empty for None."""
        if value is None:
            return ""
        if isinstance(value, float):
            return f"{value:.10g}"
        if isinstance(value, tuple | list):
            return ", ".join(f"{part:.10g}" for part in value)
        return str(value)

    def value_of(self, text: Any) -> Any:
        """Return the value of what a user has entered; None for nothing.

        Raises
        ------
        InputError
            If it is no such value.
        """
        if text is None or text == "":
            return None
        try:
            return self.key.kind.read(_typed(self.key, text), Path())
        except ValueError:
            raise InputError(
                f"The {self.label} must be {self.key.kind.name}, not {text!r}."
            ) from None


def _typed(key: Key, text: Any) -> Any:
    """Return what TOML would give for a text."""
    if not isinstance(text, str):
        return text
    if key.kind is INTEGER:
        return int(text)
    if key.kind is NUMBER:
        return parse(text)
    if _is_list(key):
        parts = [parse(part) for part in text.replace(";", ",").split(",")]
        return parts[0] if key.kind is CELL and len(parts) == 1 else parts
    return text


def _is_list(key: Key) -> bool:
    return key.kind is CELL or key.kind.name.startswith("a list of ")


def _field(key: Key) -> Field:
    widget: Widget = "text"
    if key.kind is BOOLEAN:
        widget = "switch"
    elif key.kind.choices:
        widget = "choice"
    elif key.kind in (NUMBER, INTEGER):
        widget = "number"
    option = OPTIONS.get(key.dest)
    meaning = key.meaning if option is None else option.meaning
    return Field(key, widget, key.kind.choices, meaning)


def fields_of(table: str) -> list[Field]:
    """Return the fields of a table of a problem file, without the planners' own options.

    Parameters
    ----------
    table : str
        One of :data:`GROUPS`, or ``aircraft``.
    """
    if table == "aircraft":
        (key,) = (key for key in KEYS if key.table == table and key.name == "name")
        return [Field(key, "choice", tuple(aircraft.names()), TABLES[table].rstrip("."))]
    keys = [
        key
        for key in KEYS
        if key.table == table and key.dest not in OPTIONS and key.dest not in _ELSEWHERE
    ]
    return list(map(_field, keys))


def planner_fields(planner: str) -> list[Field]:
    """Return the fields of a planner's own options."""
    own = PLANNERS[planner].options
    return [_field(key) for key in KEYS if key.dest in own]


#: Fields of a zone besides its shape.
ZONE_FIELDS = tuple(
    _field(key)
    for key in KEYS
    if key.table == "zones" and key.name in ("name", "lower", "upper", "t0", "t1")
)
