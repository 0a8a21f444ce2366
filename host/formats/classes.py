"""Classes of airspace: the words and numbers of the formats, and which classes forbid flight."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.remarks import Grade, Remark


__all__ = [
    "BY_NAME",
    "CLASSES",
    "DEFAULT",
    "AirspaceClass",
    "forbidding",
    "forbids",
    "of_icao",
    "of_openaip",
    "of_word",
    "type_and_class",
    "unknown",
]


@dataclass(frozen=True)
class AirspaceClass:
    """A row.

    Parameters
    ----------
    name : str
        Name in ``--forbid`` and in reports.
    meaning : str
        Meaning, for documents.
    forbids : bool
        The class forbids flight by default.
    words : tuple of str
        Other words of formats for this class, upper case.
    openaip : int, optional
        Number of the type in openAIP.
    """

    name: str
    meaning: str
    forbids: bool
    words: tuple[str, ...] = ()
    openaip: int | None = None


#: The classes. Classes that require a clearance or equipment forbid, because the planner has
#: neither.
CLASSES = (
    AirspaceClass("PROHIBITED", "prohibited area", True, ("P",), 3),
    AirspaceClass("RESTRICTED", "restricted area", True, ("R",), 1),
    AirspaceClass("DANGER", "danger area", True, ("Q",), 2),
    AirspaceClass(
        "REQ_AUTHORISATION",
        "zone for UAS that requires authorisation",
        True,
        ("REQ_AUTHORIZATION",),
    ),
    AirspaceClass("CONDITIONAL", "zone for UAS with conditions", True),
    AirspaceClass("USPACE", "airspace with services for UAS", True, ("U-SPACE",)),
    AirspaceClass("NO_RESTRICTION", "zone for UAS without restriction", False),
    AirspaceClass("CTR", "control zone", True, (), 4),
    AirspaceClass("MCTR", "military control zone", True, (), 36),
    AirspaceClass("TMA", "terminal area", True, (), 7),
    AirspaceClass("CTA", "control area", True, (), 26),
    AirspaceClass("LTA", "lower traffic area", True, (), 34),
    AirspaceClass("UTA", "upper traffic area", True, (), 35),
    AirspaceClass("ATZ", "aerodrome traffic zone", True, (), 13),
    AirspaceClass("MATZ", "military aerodrome traffic zone", True, (), 14),
    AirspaceClass("TIZ", "traffic information zone", True, (), 23),
    AirspaceClass("TIA", "traffic information area", True, (), 24),
    AirspaceClass("RMZ", "zone that requires a radio", True, (), 6),
    AirspaceClass("TMZ", "zone that requires a transponder", True, (), 5),
    AirspaceClass("TRA", "temporary reserved area", True, (), 8),
    AirspaceClass("TSA", "temporary segregated area", True, (), 9),
    AirspaceClass("TFR", "temporary flight restriction", True),
    AirspaceClass("FEEDING", "feeding route of a TRA or TSA", True, ("TRAFR",), 31),
    AirspaceClass("MTA", "military training area", True, (), 25),
    AirspaceClass("MTR", "military training route", True, (), 16),
    AirspaceClass("MRT", "military route", True, (), 30),
    AirspaceClass("ALERT", "alert area", True, (), 17),
    AirspaceClass("WARNING", "warning area", True, (), 18),
    AirspaceClass("PROTECTED", "protected area", True, (), 19),
    AirspaceClass(
        "OVERFLIGHT", "restriction of low flight", True, ("OFR", "OVERFLIGHT_RESTRICTION"), 29
    ),
    AirspaceClass("HTZ", "traffic zone of helicopters", True, (), 20),
    AirspaceClass("AIRWAY", "airway", True, ("AWY",), 15),
    AirspaceClass("NOTAM", "area of a NOTAM", True, ("N",)),
    AirspaceClass("NOGLIDER", "area prohibited for gliders", True, ("GP",)),
    AirspaceClass("CUSTOM", "area of a user", True),
    AirspaceClass("OTHER", "area without a class", True, ("UNC", "UNCLASSIFIED", "NONE"), 0),
    AirspaceClass("A", "airspace of class A", True),
    AirspaceClass("B", "airspace of class B", True),
    AirspaceClass("C", "airspace of class C", True),
    AirspaceClass("D", "airspace of class D", True),
    AirspaceClass("E", "airspace of class E", False),
    AirspaceClass("F", "airspace of class F", False),
    AirspaceClass("G", "airspace of class G", False),
    AirspaceClass("FIR", "flight information region", False, (), 10),
    AirspaceClass("UIR", "upper flight information region", False, (), 11),
    AirspaceClass("ADIZ", "air defence identification zone", False, (), 12),
    AirspaceClass("ACC", "sector of area control", False, ("ACCSEC", "ACC_SECTOR"), 27),
    AirspaceClass("FIS", "sector of the flight information service", False, ("FIS_SECTOR",), 33),
    AirspaceClass(
        "VFR", "sector or route of visual flight", False, ("VFRSEC", "VFR_SECTOR", "VFRR"), 32
    ),
    AirspaceClass("GLIDING", "gliding sector", False, ("GSEC", "GLIDING_SECTOR"), 21),
    AirspaceClass("WAVE", "wave window", False, ("W",)),
    AirspaceClass(
        "SPORT", "area of aerial sport", False, ("ASRA", "AERIAL_SPORTING_RECREATIONAL"), 28
    ),
    AirspaceClass("TRANSPONDER", "recommended transponder code", False, ("TRP", "TRZ"), 22),
)

#: The rows by name.
BY_NAME = MappingProxyType({row.name: row for row in CLASSES})
_BY_WORD = {word: row for row in CLASSES for word in (row.name, *row.words)}
_BY_NUMBER = {row.openaip: row for row in CLASSES if row.openaip is not None}
#: Names of the classes that forbid by default.
DEFAULT = frozenset(row.name for row in CLASSES if row.forbids)
# The class of areas whose type or class says nothing.
_NOTHING = "OTHER"
# Classes of ICAO by their numbers in openAIP.
_ICAO = "ABCDEFG"
_NO_CLASS = 8


def of_word(text: str) -> str:
    """Return the name of the class that a word of a format means, or the word if none does."""
    word = text.strip().upper()
    row = _BY_WORD.get(word)
    return row.name if row else word


def of_openaip(stated: Any) -> str:
    """Return the name of the class of an openAIP type; one like ``TYPE 37`` if it is unknown."""
    row = _BY_NUMBER.get(stated) if _is_whole(stated) else None
    return row.name if row else f"TYPE {stated!r:.20}"


def of_icao(stated: Any) -> str:
    """Return the name of an ICAO class of openAIP, OTHER for none; ``CLASS 9`` if it is unknown."""
    if not _is_whole(stated) or stated not in (*range(len(_ICAO)), _NO_CLASS):
        return f"CLASS {stated!r:.20}"
    return _NOTHING if stated == _NO_CLASS else _ICAO[stated]


def _is_whole(stated: Any) -> bool:
    return isinstance(stated, int) and not isinstance(stated, bool)


def type_and_class(type_name: str, class_name: str) -> tuple[str, str]:
    """Return the category of a zone, and its class if that is another one, otherwise nothing.

    The category is the type, or the class where the type is ``OTHER``.
    """
    if type_name == _NOTHING:
        return class_name, ""
    return type_name, "" if class_name in (_NOTHING, type_name) else class_name


def forbidding(text: str) -> frozenset[str]:
    """Return the classes of a list like ``default,E``; ``default`` and ``all`` stand for several.

    Raises
    ------
    InputError
        If a name is unknown.
    """
    found: set[str] = set()
    for part in text.split(","):
        word = part.strip().upper()
        if word == "DEFAULT":
            found |= DEFAULT
        elif word == "ALL":
            found |= set(BY_NAME)
        elif word in _BY_WORD:
            found.add(_BY_WORD[word].name)
        else:
            raise InputError(
                f"There is no class of airspace {part.strip()!r}; give default, all or some of "
                f"{', '.join(BY_NAME)} (--forbid)."
            )
    return frozenset(found)


def forbids(category: str, chosen: frozenset[str] = DEFAULT, *, airspace_class: str = "") -> bool:
    """Return whether a category, or the class beside it, forbids flight; unknown ones do."""
    names = (category, airspace_class) if airspace_class else (category,)
    return any(name in chosen or name not in BY_NAME for name in names)


def unknown(names: Iterable[str], lines: Mapping[str, int] | None = None) -> tuple[Remark, ...]:
    """Return a warning for each name that is no class of the table, with its line in the file."""
    return tuple(
        Remark(
            Grade.WARNING,
            f"{name}{f' (line {lines[name]})' if lines else ''} is no type or class that is known, "
            "so it forbids flight; correct the file if the area is open to flight",
        )
        for name in names
        if name and name not in BY_NAME
    )
