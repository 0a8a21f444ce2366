"""Recognition of certainly invalid inputs, by the libraries of their formats, not the program.

A damaged file may still be a good one. A file is bad if its format's own reader refuses it.
"""

import codecs
import contextlib
import csv
import io
import json
import math
import tomllib
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Callable, Mapping

import numpy as np


def is_number(text: str) -> bool:
    """Return whether Python reads a text as a finite number."""
    with contextlib.suppress(ValueError):
        return math.isfinite(float(text)) or bool(int(text))
    return False


def is_unreadable(name: str, content: bytes) -> bool:
    """Return whether the reader of a format refuses a file; False without a reader here."""
    read = _READERS.get(name.rpartition(".")[2])
    if read is None:
        return False
    try:
        read(content)
    except Exception:  # Each reader has its own errors.
        return True
    return False


def _text(content: bytes) -> str:
    """Decode a text as its mark of the order of bytes says, whatever it declares, or as UTF-8."""
    marks = (codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE, codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
    wide = [f"utf-{32 if len(mark) == 4 else 16}" for mark in marks if content.startswith(mark)]
    return content.decode(wide[0] if wide else "utf-8-sig")


def _json(content: bytes) -> None:
    json.loads(_text(content))


def _toml(content: bytes) -> None:
    tomllib.loads(content.decode("utf-8"))


def _xml(content: bytes) -> None:
    ET.fromstring(_text(content).strip())


def _csv(content: bytes) -> None:
    rows = list(csv.reader(io.StringIO(content.decode("utf-8-sig"))))
    for row in rows[1:]:
        for cell in row:
            float(cell or 0)


def _array(content: bytes) -> None:
    # Not the content: a few bytes may state terabytes.
    file = io.BytesIO(content)
    major, _ = np.lib.format.read_magic(file)
    read = (
        np.lib.format.read_array_header_1_0 if major == 1 else np.lib.format.read_array_header_2_0
    )
    read(file)


def _archive(content: bytes) -> None:
    with zipfile.ZipFile(io.BytesIO(content)) as file:
        for key in ("elevation", "dx_m", "dy_m"):
            with file.open(f"{key}.npy") as member:
                _array(member.read(4096))


_READERS: Mapping[str, Callable[[bytes], None]] = {
    "json": _json,
    "geojson": _json,
    "plan": _json,
    "toml": _toml,
    "kml": _xml,
    "csv": _csv,
    "npy": _array,
    "npz": _archive,
}
