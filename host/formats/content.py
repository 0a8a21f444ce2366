"""The text of a file whose format is recognized by its content."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.inputs import parse_json, read_text


__all__ = ["Content", "read_content"]


class Content:
    """The text of a file, and the JSON in it.

    Parameters
    ----------
    text : str
        The text.
    """

    def __init__(self, text: str) -> None:
        self.text = text

    @cached_property
    def _parsed(self) -> tuple[Any, str | None]:
        try:
            return parse_json(self.text), None
        except ValueError as error:
            return None, str(error)

    @property
    def json(self) -> Any:
        """The value of the text parsed as JSON, or None."""
        return self._parsed[0]

    @property
    def json_error(self) -> str | None:
        """The reason why the text is not JSON, or None."""
        return self._parsed[1]

    @property
    def is_xml(self) -> bool:
        """True for a text that begins like XML."""
        return self.text.lstrip().startswith("<")


def read_content(path: str | Path) -> Content:
    """Return the text of a file of zones.

    Raises
    ------
    InputError
        If the file cannot be read, or is not text.
    """
    try:
        return Content(read_text(Path(path), "utf-8-sig"))
    except OSError as error:
        reason = error.strerror or "unknown reason"
        raise InputError(f"Cannot read no-fly file {str(path)!r}: {reason}.") from None
    except UnicodeDecodeError:
        is_kmz = str(path).lower().endswith(".kmz")
        why = "a KMZ archive; unzip it and give the .kml in it" if is_kmz else "not text in UTF-8"
        raise InputError(f"No-fly file {str(path)!r} is {why}.") from None
