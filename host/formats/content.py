"""The content of a file whose format is recognized by it: bytes, text, JSON or XML."""

from __future__ import annotations

import codecs
import re
from functools import cached_property
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from defusedxml import DefusedXmlException
from defusedxml.ElementTree import fromstring

from pathgene.host.errors import InputError
from pathgene.host.inputs import parse_json, read_bytes


__all__ = ["Content", "read_content"]

# Marks of the order of bytes; the longer ones come first, as UTF-32 begins like UTF-16.
_MARKS = (
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
# XML in UTF-16 may have no such mark.
_BEGINNINGS = ((b"<\0", "utf-16-le"), (b"\0<", "utf-16-be"))
_DECLARED = re.compile(rb"""^\s*<\?xml[^>]*?\sencoding\s*=\s*["']([\w.:-]+)["']""")
_WIDE = re.compile(r"(?i)(utf|ucs|iso-10646-ucs)[-_]?(16|32|2|4)")
# The separator of texts in a sequence of JSON, which begins each of them.
_SEPARATOR = "\x1e"
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0e-\x1a\x1c\x1d\x1f]")
# Bytes in which text of two bytes a character is recognised.
_SAMPLE = 4_000
_FIRST_TAG = re.compile(r"<(?![?!])[^\s/>]+")
_PREFIX = re.compile(r"[<\s/]([A-Za-z_][\w.-]*):[A-Za-z_]")
# Kinds of files by their first bytes or words.
_BYTES = (
    (b"PK\x03\x04", "a ZIP or KMZ archive"),
    (b"\x89PNG", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
    (b"%PDF", "a PDF"),
    (b"SQLite format 3", "a GeoPackage or another database of SQLite"),
    (b"\x00\x00\x27\x0a", "a shapefile"),
    (b"II*\x00", "a GeoTIFF"),
    (b"MM\x00*", "a GeoTIFF"),
    (b"\x1f\x8b", "an archive of gzip"),
)
_TEXTS: tuple[tuple[str, str], ...] = (
    (r"(?:\A|(?<=[\r\n]))A[CN][ \t]+\S", "OpenAir without an outline (DP, DA, DB, DC or DY)"),
    (r"(?im:\bINCLUDE=(YES|NO)\b|^TITLE=)", "airspace in the format of Tim Newport-Peace"),
    (r"^QGC WPL \d+", "a list of waypoints or a fence of Mission Planner"),
    (
        r"(?i)^\s*(SRID=\d+;)?(POLYGON|MULTIPOLYGON|LINESTRING|POINT) {0,9}Z? {0,9}\(",
        "well-known text",
    ),
    (
        # JSON that is cut short may have such words.
        r"(?i)^(?!\s*[{\[])[^\n]{0,200}\b(lat|lon|latitude|longitude|x)\b[^\n]{0,200}[,;]",
        "a table of positions",
    ),
    (
        r"\A(#[^\r\n]*[\r\n]+)*[-+]?\d[\d.]*[ \t,;]+[-+]?\d[\d.]*[ \t]*([\r\n]|\Z)",
        "a polygon of Mission Planner (.poly), which does not say whether to stay inside or "
        "outside: save it as a .fen to stay inside, or as GeoJSON to stay outside",
    ),
    (r"(?i)^\s*<!doctype html|^\s*<html", "a web page"),
    (r"\A\s*0[ \t]*[\r\n]+\s*SECTION\b", "a drawing in DXF"),
    (r"^\s*[{\[]", "JSON"),
)
_ROOTS = {
    "gpx": "GPX",
    "osm": "OpenStreetMap",
    "html": "a web page",
    "AIXMBasicMessage": "AIXM",
    "FeatureCollection": "GML",
    "svg": "a drawing in SVG",
}


class Content:
    """The content of a file.

    Parameters
    ----------
    data : bytes
        The bytes.
    name : str
        Name of the file, which a reader needs only if the content is ambiguous.
    """

    def __init__(self, data: bytes, name: str = "") -> None:
        self.data = data
        self.name = name

    @cached_property
    def text(self) -> str:
        """The text, decoded by its mark or XML declaration, or as UTF-8, or as Windows-1252."""
        for encoding in (self._encoding, "utf-8-sig", "cp1252"):
            try:
                return self.data.decode(encoding)
            except (LookupError, UnicodeError):
                continue
        return self.data.decode("latin-1")

    @property
    def _encoding(self) -> str:
        for mark, encoding in (*_MARKS, *_BEGINNINGS):
            if self.data.startswith(mark):
                return encoding
        if wide := _unmarked_wide(self.data[:_SAMPLE]):
            return wide
        declared = _DECLARED.match(self.data)
        encoding = declared.group(1).decode("ascii") if declared else "utf-8-sig"
        # A declaration in single bytes is not UTF-16: Mission Planner writes one into UTF-8.
        return "utf-8-sig" if _WIDE.match(encoding) else encoding

    @property
    def is_empty(self) -> bool:
        """True if there is nothing but blanks, a mark of the order of bytes, or separators."""
        return not self.text.replace(_SEPARATOR, "").replace("\ufeff", "").strip()

    @property
    def is_text(self) -> bool:
        """True if the text has no control characters, which binary files have."""
        return _CONTROL.search(self.text) is None

    @cached_property
    def _parsed_json(self) -> tuple[Any, str | None]:
        try:
            return parse_json(self.text), None
        except ValueError as error:
            return _sequence(self.text, str(error))

    @property
    def json(self) -> Any:
        """The value of the text parsed as JSON, or None; a sequence is a FeatureCollection."""
        return self._parsed_json[0]

    @property
    def json_error(self) -> str | None:
        """The reason why the text is not JSON, or None."""
        return self._parsed_json[1]

    @property
    def is_xml(self) -> bool:
        """True for a text that begins like XML."""
        return self.text.lstrip().startswith("<")

    @cached_property
    def _parsed_xml(self) -> tuple[ET.Element | None, str | None]:
        if not self.is_xml:
            return None, "it does not begin with <"
        text = self.text.lstrip()
        for declaring in (_as_is, _declaring_prefixes):
            try:
                # Entities could grow without bound, or name other files.
                root: ET.Element = fromstring(declaring(text))
            except DefusedXmlException:
                return None, "it declares entities, which are refused; save it without them"
            except (ET.ParseError, ValueError) as error:
                why = str(error)
                if "unbound prefix" not in why:
                    break
            else:
                return root, None
        return None, why

    @property
    def xml(self) -> ET.Element | None:
        """The root of the text as XML, or None; prefixes that are not declared are accepted."""
        return self._parsed_xml[0]

    @property
    def xml_error(self) -> str | None:
        """The reason why the text is not XML, or None."""
        return self._parsed_xml[1]

    @property
    def looks_like(self) -> str:
        """The kind of file that the content looks like, in words; empty for none."""
        for start, kind in _BYTES:
            if self.data.startswith(start):
                return kind
        if not self.is_text:
            return "a binary file"
        if self.xml is not None:
            tag = self.xml.tag.rpartition("}")[2]
            return _ROOTS.get(tag, f"XML with the root {tag!r}")
        return next((kind for text, kind in _TEXTS if re.search(text, self.text[:100_000])), "")


def _unmarked_wide(data: bytes) -> str:
    """Return the encoding of text with two bytes a character and no mark, or an empty string."""
    first, second = data[::2], data[1::2]
    for zeros, characters, encoding in ((second, first, "utf-16-le"), (first, second, "utf-16-be")):
        if 0 not in characters and zeros.count(0) > len(zeros) / 2:
            return encoding
    return ""


def _sequence(text: str, why: str) -> tuple[Any, str | None]:
    """Return the members of a sequence of JSON, one a line or after separators, or the fault."""
    is_separated = text.startswith(_SEPARATOR)
    texts = text.split(_SEPARATOR if is_separated else "\n")
    members: list[Any] = []
    for number, part in enumerate(texts, start=0 if is_separated else 1):
        if not part.strip():
            continue
        try:
            value = parse_json(part)
        except ValueError as error:
            if members:
                why = f"{'text' if is_separated else 'line'} {number} of the sequence: {error}"
            return None, why
        if not isinstance(value, dict):
            return None, why
        listed = value.get("features") if value.get("type") == "FeatureCollection" else None
        members += listed if isinstance(listed, list) else [value]
    if not members:
        return None, "it is empty"
    return {"type": "FeatureCollection", "features": members}, None


def _as_is(text: str) -> str:
    return text


def _declaring_prefixes(text: str) -> str:
    """Return XML whose root declares all prefixes that it uses, as Google Earth forgives."""
    first = _FIRST_TAG.search(text)
    if first is None:
        return text
    root = text[first.start() : text.find(">", first.end())]
    used = set(_PREFIX.findall(text)) - {"xml", "xmlns", *re.findall(r"xmlns:([\w.-]+)", root)}
    declarations = "".join(f' xmlns:{prefix}="urn:{prefix}"' for prefix in sorted(used))
    return f"{text[: first.end()]}{declarations}{text[first.end() :]}"


def read_content(path: str | Path) -> Content:
    """Return the content of a file of zones.

    Raises
    ------
    InputError
        If the file cannot be read.
    """
    try:
        return Content(read_bytes(Path(path)), Path(path).name)
    except OSError as error:
        reason = error.strerror or "unknown reason"
        raise InputError(f"Cannot read no-fly file {str(path)!r}: {reason}.") from None
