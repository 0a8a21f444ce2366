"""Height limits in zone files: numbers with unit and reference, and texts."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from pathgene.host.errors import InputError
from pathgene.host.formats.features import Limit, Reference
from pathgene.host.numeric import is_number, parse
from pathgene.host.remarks import Grade, Remark


__all__ = [
    "FOOT_M",
    "Own",
    "above_ground",
    "height_of",
    "limit",
    "limit_text",
    "own_limits",
    "plain_number",
    "stated_limits",
]

FOOT_M = 0.3048
_FLIGHT_LEVEL_M = 100 * FOOT_M

_UNITS_M = {
    **dict.fromkeys(("M", "MT", "MTR", "METER", "METERS", "METRE", "METRES"), 1.0),
    **dict.fromkeys(("FT", "FEET", "FOOT", "'"), FOOT_M),
    "FL": _FLIGHT_LEVEL_M,
}
_REFERENCES = {
    **dict.fromkeys(("AMSL", "MSL", "ASL", "ALT", "QNH"), Reference.AMSL),
    **dict.fromkeys(("AGL", "ASFC", "GND", "GROUND", "SFC", "SURFACE"), Reference.AGL),
    **dict.fromkeys(("WGS84", "WGS", "HAE"), Reference.WGS84),
    "STD": Reference.STANDARD,
}
_GROUND = frozenset({"GND", "GROUND", "SFC", "SURFACE"})
_UNLIMITED = frozenset({"UNL", "UNLIM", "UNLIMITED", "UNLTD"})
_WORD = re.compile(r"WGS84|[A-Z]+|[-+]?\d[\d.,]*|'")
# Marks of feet.
_PRIMES = str.maketrans(dict.fromkeys("’′´`", "'"))
# A point before three digits may separate thousands, but not after a 0.
_NUMBER = re.compile(r"[-+]?(?:0(?:\.\d*)?|(?:\d+|\d{1,3}(?:,\d{3})+)(?:\.(?:\d{0,2}|\d{4,}))?)")

# Properties that state a lower and an upper limit; the first one present of each is read.
_LOWER = ("lowerLimit", "lower_limit", "lowerCeiling", "lowerAltitude", "floor", "bottom", "base")
_UPPER = ("upperLimit", "upper_limit", "upperCeiling", "upperAltitude", "ceiling", "top")
# Names of properties, as letters only, that state unit or reference of ``lower`` and ``upper``.
_BESIDE = re.compile(
    r"(?P<before>lower|upper)?(vertical|altitude|alt|height|heights|limit|limits)?"
    r"(?:(?P<unit>units?|uom)|(?P<reference>ref|reference|datum))(?P<after>lower|upper)?"
)


def above_ground(height_m: float) -> str:
    """Return the text of a limit above the ground, from which :func:`limit_text` reads it."""
    return f"{_number_text(height_m)} m AGL"


def _number_text(number: float) -> str:
    """Return the text of a number in which no point could separate thousands."""
    text = repr(float(number)).removesuffix(".0")
    return f"{text}0" if re.search(r"[.][0-9]{3}$", text) else text


def limit(value: Any, unit: Any, reference: Any) -> Limit:
    """Return a limit from a number, a word for its unit and a word for its reference.

    Raises
    ------
    InputError
        If one of the three is invalid.
    """
    if not is_number(value):
        raise InputError(f"a limit of height must be a number, not {value!r}.")
    metres = _UNITS_M.get(str(unit).strip().upper())
    if metres is None:
        raise InputError(f"the unit of a limit of height must be m, ft or FL, not {unit!r}.")
    surface = _REFERENCES.get(str(reference).strip().upper())
    if surface is None:
        raise InputError(
            "the reference of a limit of height must be AGL, AMSL, WGS84 or STD, not "
            f"{reference!r}."
        )
    if metres == _FLIGHT_LEVEL_M:
        if surface in (Reference.AGL, Reference.WGS84):
            raise InputError(f"a flight level, {value:g}, has no height {surface}.")
        return Limit(float(value) * metres, Reference.STANDARD, f"FL {value:g}")
    name = str(unit).strip().lower().replace("'", "ft")
    return Limit(float(value) * metres, surface, f"{value:g} {name} {surface}")


def limit_text(text: str, unit: str | None = None, reference: str | None = None) -> Limit | None:
    """Return the limit that a text states, such as ``4500 ft AMSL``, or None for no limit.

    Parameters
    ----------
    text : str
        The text.
    unit, reference : str, optional
        Unit and reference that the format assumes if the text has none.

    Raises
    ------
    ValueError
        If the text states no limit, or more than one, or could mean several.
    """
    upper = text.upper().replace("WGS-84", "WGS84").translate(_PRIMES)
    words = _WORD.findall(upper)
    if not words or re.sub(r"[\s+.]", "", _WORD.sub("", upper)):
        raise ValueError(text)
    if len(words) == 1 and words[0] in _UNLIMITED:
        return None
    if len(words) == 1 and words[0] in _GROUND:
        return Limit(0.0, Reference.AGL, words[0])
    numbers = [word for word in words if word[-1] in "0123456789.," and not word.startswith("WGS")]
    # A unit may stand in the text and beside it.
    units = list(dict.fromkeys(word for word in words if word in _UNITS_M))
    stated = [word for word in words if word in _REFERENCES]
    surfaces = {_REFERENCES[word] for word in stated}
    # A point before three digits may be a decimal point or separate thousands, and a minus after a
    # word may separate two limits.
    is_number_clear = len(numbers) == 1 and _NUMBER.fullmatch(numbers[0]) is not None
    is_number_clear = is_number_clear and ("-" not in numbers[0] or words[0] == numbers[0])
    is_all_known = len(numbers) + len(stated) == sum(word not in _UNITS_M for word in words)
    if not is_number_clear or not is_all_known or len(units) > 1 or len(surfaces) > 1:
        raise ValueError(text)
    chosen_unit = units[0] if units else unit
    if chosen_unit == "FL":
        surfaces = surfaces or {Reference.STANDARD}
    surface = next(iter(surfaces)) if surfaces else _REFERENCES.get(reference or "")
    if chosen_unit is None or surface is None:
        raise ValueError(text)
    try:
        return limit(float(numbers[0].replace(",", "")), chosen_unit, surface)
    except InputError:
        # A flight level above the ground.
        raise ValueError(text) from None


def height_of(text: str, what: str) -> Limit:
    """Return the height above mean sea level or above the ground that a text states.

    Parameters
    ----------
    text : str
        The text, such as ``120 m AGL``.
    what : str
        Its meaning, for the sentence of an error.

    Raises
    ------
    InputError
        If it states anything else.
    """
    try:
        stated = limit_text(text)
    except (ValueError, InputError):
        stated = None
    if stated is None or stated.reference not in (Reference.AGL, Reference.AMSL):
        raise InputError(
            f"The {what} must be a number of metres, or a height above the ground such as "
            f"'120 m AGL', not {text!r}."
        )
    return stated


class Own(NamedTuple):
    """The lower and the upper limit that properties state.

    ``read`` has the names of the properties that are read besides ``lower`` and ``upper``,
    ``remarks`` a note on each assumption.
    """

    lower: Limit | None
    upper: Limit | None
    read: tuple[str, ...]
    remarks: tuple[Remark, ...]


def own_limits(properties: Mapping[str, Any]) -> Own:
    """Return the limits that the properties ``lower`` and ``upper`` state.

    A limit is a number or a text such as ``120 m AGL``. Unit and reference may stand beside it, as
    ``unit`` or ``upper_reference``. A number without them is in metres above mean sea level.

    Raises
    ------
    InputError
        If a limit, or a unit or reference beside it, is invalid.
    """
    limits: list[Limit | None] = []
    read: list[str] = []
    assumed: list[str] = []
    for side in ("lower", "upper"):
        value = properties.get(side)
        if value is None or (isinstance(value, str) and value.strip() in ("", "none")):
            limits.append(None)
            continue
        beside = _beside(properties, side)
        read += (name for name, _ in beside.values())
        limits.append(_own_limit(side, value, beside))
        if isinstance(value, str) and plain_number(value) is value:
            assumed += _words_read(side, value, limits[-1])
            continue
        if not beside:
            assumed.append("limits without a unit or reference are metres above sea level")
        elif "unit" not in beside and not _is_level(limits[-1]):
            assumed.append("limits without a unit are metres")
        elif "reference" not in beside and not _is_level(limits[-1]):
            assumed.append("limits without a reference are above sea level")
    remarks = tuple(Remark(Grade.NOTE, text) for text in dict.fromkeys(assumed))
    return Own(limits[0], limits[1], tuple(dict.fromkeys(read)), remarks)


def _words_read(name: str, value: Any, stated: Limit | None) -> Iterator[str]:
    """Yield the meaning of a limit that is a word, such as ``ground`` or ``unlimited``."""
    if isinstance(value, str) and not re.search("[0-9]", value):
        meaning = "no limit" if stated is None else "the ground below the zone"
        yield f"{name} {value.strip()!r} is read as {meaning}"


def _is_level(stated: Limit | None) -> bool:
    return stated is not None and stated.reference is Reference.STANDARD


def _beside(properties: Mapping[str, Any], side: str) -> dict[str, tuple[str, Any]]:
    """Return the properties that state ``unit`` and ``reference`` of a limit, with their names.

    Raises
    ------
    InputError
        If two properties contradict each other.
    """
    found: dict[str, tuple[str, Any]] = {}
    own: set[str] = set()
    for name, value in properties.items():
        match = _BESIDE.fullmatch(re.sub("[^a-z]", "", name.lower()))
        if match is None or value is None or (isinstance(value, str) and not value.strip()):
            continue
        named = match["before"] or match["after"]
        kind = "unit" if match["unit"] else "reference"
        if named not in (None, side) or (kind in own and named is None):
            continue
        if kind in found and (kind in own or named is None) and found[kind][1] != value:
            raise InputError(f"{found[kind][0]} and {name} contradict each other.")
        found[kind] = name, value
        if named:
            own.add(kind)
    return found


def _own_limit(side: str, value: Any, beside: Mapping[str, tuple[str, Any]]) -> Limit | None:
    value = plain_number(value)
    if is_number(value):
        if not beside:
            return Limit(float(value), Reference.AMSL)
        text, unit, reference = _number_text(value), "M", "AMSL"
    elif isinstance(value, str):
        text, unit, reference = value, None, None
    else:
        raise InputError(f"{side} must be a finite number, not {value!r}.")
    if not re.search("[0-9]", text):
        beside = {}
    try:
        return limit_text(
            " ".join((text, *(str(word) for _, word in beside.values()))), unit, reference
        )
    except ValueError:
        pass
    if beside:
        stated = " and ".join(f"{name} {word!r}" for name, word in beside.values())
        raise InputError(
            f"its {side} {value!r} with {stated} is no height; give m, ft or FL, and AMSL, AGL or "
            "WGS84."
        )
    try:
        limit_text(text, None, "AMSL")
    except ValueError:
        raise InputError(f"{side} must be a finite number, not {value!r}.") from None
    raise InputError(f"{side} {value!r} has no reference; add AMSL or AGL: '{value.strip()} AMSL'.")


def plain_number(value: Any) -> Any:
    """Return the number of a text that is only a number, as tables state it, or the value."""
    if isinstance(value, str):
        try:
            return parse(value.strip())
        except ValueError:
            pass
    return value


def stated_limits(properties: Mapping[str, Any]) -> Own:
    """Return the limits that properties such as ``floor`` and ``upperLimit`` state.

    A limit is read if its value has number, unit and reference: a text such as ``FL 95``, or an
    object with ``value``, ``unit`` and ``reference``.
    """
    lower, upper = (
        next((name for name in names if name in properties), "") for names in (_LOWER, _UPPER)
    )
    limits: dict[str, Limit | None] = {}
    words: list[str] = []
    for name in (lower, upper):
        try:
            limits[name] = _limit_of(properties[name])
        except (KeyError, ValueError, InputError):
            continue
        words += _words_read(name, properties[name], limits[name])
    remarks = tuple(Remark(Grade.NOTE, text) for text in words)
    return Own(limits.get(lower), limits.get(upper), tuple(limits), remarks)


def _limit_of(value: Any) -> Limit | None:
    if isinstance(value, str):
        return limit_text(value)
    if not isinstance(value, dict):
        raise ValueError
    reference = value.get("referenceDatum", value.get("reference"))
    if isinstance(reference, int):
        raise ValueError
    return limit(value.get("value"), value.get("unit", value.get("uom")), reference)
