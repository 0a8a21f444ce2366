"""``.fen``, the old fence of Mission Planner: a return point, then the inclusion polygon."""

from __future__ import annotations

import re
from collections.abc import Iterator

from pathgene.host.errors import InputError
from pathgene.host.formats.areas import check_degrees
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, Feature, Position, Read, label
from pathgene.host.remarks import Grade, Remark


__all__ = ["features", "recognises"]

_PAIR = re.compile(r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
# A return point and a closed triangle.
_FEWEST_ROWS = 5


def recognises(content: Content) -> bool:
    """Return whether a text is rows of two numbers, or is named ``.fen``.

    A polygon without a return point, a ``.poly``, looks alike but is closed by its first row.
    """
    if content.name.lower().endswith(".fen"):
        return content.is_text
    if content.name.lower().endswith(".poly"):
        return False
    first = next((line for line in content.text.splitlines() if line[:1] not in ("#", "")), "")
    if not all(map(_PAIR.fullmatch, first.replace(",", " ").split())):
        return False
    rows = _rows(content)
    if len(rows) < _FEWEST_ROWS or rows[0][1] == rows[-1][1]:
        return False
    return all(len(words) == 2 and all(map(_PAIR.fullmatch, words)) for _, words in rows)


def features(content: Content) -> Iterator[Read]:
    """Yield the inclusion polygon."""
    try:
        positions = [_position(number, words) for number, words in _rows(content)]
        if len(positions) < _FEWEST_ROWS - 1:
            raise InputError("a fence must have a return point and three corners or more.")
        ring = tuple(positions[1:])
        ring = ring[:-1] if ring[0] == ring[-1] else ring
        if len(set(ring)) < 3:
            raise InputError("a fence must have a return point and three corners or more.")
        check_degrees(positions, "latitude comes first.")
    except InputError as error:
        yield Bad(label("fence", 1), str(error))
        return
    remarks: tuple[Remark, ...] = ()
    if not _is_inside(ring, positions[0]):
        text = "its return point, the first row, lies outside; a corner there is not read"
        remarks = (Remark(Grade.WARNING, text),)
    yield Feature(1, "outside of the fence", (ring,), kind="fence", keeps_in=True, remarks=remarks)


def _is_inside(ring: tuple[Position, ...], place: Position) -> bool:
    """Return whether a place lies in a ring, by the even-odd rule, or is one of its corners."""
    if place in ring:
        return True
    (x, y), inside = place, False
    for (xa, ya), (xb, yb) in zip(ring, (*ring[1:], ring[0]), strict=True):
        if (ya <= y) != (yb <= y) and x < xa + (y - ya) * (xb - xa) / (yb - ya):
            inside = not inside
    return inside


def _rows(content: Content) -> list[tuple[int, list[str]]]:
    """Return the rows that are not comments, with their numbers."""
    lines = enumerate(content.text.splitlines(), start=1)
    split = ((number, line.replace(",", " ").split()) for number, line in lines)
    return [(number, words) for number, words in split if words and not words[0].startswith("#")]


def _position(number: int, words: list[str]) -> Position:
    if len(words) != 2 or not all(map(_PAIR.fullmatch, words)):
        raise InputError(f"line {number} must be a latitude and a longitude.")
    return float(words[1]), float(words[0])
