"""Members of a JSON list of zones: each is read separately, so bad ones do not hide good ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.formats.areas import MOST_NAME
from pathgene.host.formats.features import Bad, LeftOut, Limit, Read, label


__all__ = ["Member", "check_order", "members", "plain_text", "read_members", "sized"]


@dataclass(frozen=True)
class Member:
    """A member of a list: a GeoJSON Feature, or an object with its geometry among its properties.

    Parameters
    ----------
    number : int
        Place in the list, from 1.
    name : str
        Name or identifier; empty for none.
    properties : mapping
        The properties.
    geometry : object
        The geometry as in the file.
    whole : mapping
        The member as in the file.
    """

    number: int
    name: str
    properties: Mapping[str, Any]
    geometry: Any
    whole: Mapping[str, Any] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """Number and name in the file."""
        return label("feature", self.number, self.name)


def members(document: Any) -> list[Any]:
    """Return the members of a FeatureCollection, a list or a page of a service, or the document."""
    if isinstance(document, list):
        return document
    if not isinstance(document, dict):
        return []
    listed = next((document[key] for key in ("features", "items") if key in document), None)
    return listed if isinstance(listed, list) else [document]


def properties_of(value: Any) -> Mapping[str, Any]:
    """Return the properties of a member, or of an object that is not a member."""
    if not isinstance(value, dict):
        return {}
    if value.get("type") != "Feature":
        return value
    properties = value.get("properties")
    return properties if isinstance(properties, dict) else {}


def read_members(document: Any, reader: Callable[[Member], Iterator[Read]]) -> Iterator[Read]:
    """Yield the parts that a reader makes of each member; an InputError makes the member bad."""
    for number, value in enumerate(members(document), start=1):
        properties = properties_of(value)
        name = next(filter(None, map(plain_text, map(properties.get, _NAMES))), "")
        geometry = value.get("geometry") if isinstance(value, dict) else None
        whole = value if isinstance(value, dict) else {}
        member = Member(number, name, properties, geometry, whole)
        try:
            if not isinstance(value, dict):
                raise InputError("it is not an object.")
            if value.get("type") == "Feature" and not isinstance(
                value.get("properties"), dict | None
            ):
                raise InputError("its properties must be an object.")
            parts = list(reader(member)) or [LeftOut(member.label, "its geometry is empty")]
        except InputError as error:
            parts = [Bad(member.label, str(error))]
        yield from parts


_NAMES = (
    "name",
    "Name",
    "NAME",
    "identifier",
    "designator",
    "IDENT",
    "APT1_NAME",
    "id",
    "_id",
)


def plain_text(value: Any) -> str:
    """Return a text, a number, or the English text in a list of texts with languages."""
    if isinstance(value, list):
        texts = [each for each in value if isinstance(each, dict) and each.get("text")]
        english = (each for each in texts if str(each.get("lang", "")).startswith("en"))
        value = next(english, texts[0] if texts else {}).get("text", "")
    is_plain = isinstance(value, str | int | float) and not isinstance(value, bool)
    return " ".join(str(value).split())[:MOST_NAME] if is_plain else ""


def sized(value: Any) -> float:
    """Return the radius of a circle, metres.

    Raises
    ------
    InputError
        If it is not a number above 0.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < 1e8:
        raise InputError(f"the radius of a circle must be a number above 0, not {value!r}.")
    return float(value)


def check_order(lower: Limit | None, upper: Limit | None) -> None:
    """Check that a lower limit is not above the upper limit with the same reference.

    Raises
    ------
    InputError
        If it does.
    """
    if lower and upper and lower.reference is upper.reference and lower.height_m > upper.height_m:
        raise InputError(
            f"its lower limit, {lower.height_m:g} m, lies above its upper, {upper.height_m:g} m."
        )
