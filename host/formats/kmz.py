"""KMZ: an archive with a KML document, whose name is ``doc.kml`` or the first ``.kml``."""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Iterator

from pathgene.host.errors import InputError
from pathgene.host.formats import kml
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import LeftOut, Read
from pathgene.host.inputs import MOST_TEXT_BYTES


__all__ = ["features", "recognises"]

# Maximum number of files in an archive; overlays may have hundreds of pictures.
_MOST_FILES = 10_000


def recognises(content: Content) -> bool:
    """Return whether the bytes are an archive, by their beginning and a KML document in them."""
    if not content.data.startswith(b"PK\x03\x04"):
        return False
    try:
        with _opened(content) as archive:
            return content.name.lower().endswith(".kmz") or bool(_documents(archive))
    except InputError:
        return content.name.lower().endswith(".kmz")


def features(content: Content) -> Iterator[Read]:
    """Yield the areas of the document; other documents of the archive are ignored.

    Raises
    ------
    InputError
        If the archive is broken, encrypted or too large, or has no KML document.
    """
    with _opened(content) as archive:
        names = _documents(archive)
        if not names:
            raise InputError("the archive has no .kml document.")
        document = Content(_unpacked(archive, names[0]), names[0])
    yield from kml.features(document)
    for name in names[1:]:
        yield LeftOut(f"{name!r} in the archive", "only the first document is read", True)


def _opened(content: Content) -> zipfile.ZipFile:
    try:
        archive = zipfile.ZipFile(io.BytesIO(content.data))
    except (zipfile.BadZipFile, ValueError, NotImplementedError):
        raise InputError("the archive is broken; save it again.") from None
    if len(archive.infolist()) > _MOST_FILES:
        raise InputError(f"the archive has more than {_MOST_FILES} files.")
    return archive


def _documents(archive: zipfile.ZipFile) -> list[str]:
    """Return the names of the KML documents, the main one first."""
    names = [name for name in archive.namelist() if name.lower().endswith(".kml")]
    return sorted(names, key=lambda name: name.lower() != "doc.kml")


def _unpacked(archive: zipfile.ZipFile, name: str) -> bytes:
    """Return a document; it is refused if it unpacks to more than the maximum size of a text."""
    try:
        with archive.open(name) as file:
            data = file.read(MOST_TEXT_BYTES + 1)
    except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, RuntimeError, OSError):
        raise InputError(
            f"{name!r} in the archive is broken or encrypted; save it again."
        ) from None
    if len(data) > MOST_TEXT_BYTES:
        raise InputError(
            f"{name!r} in the archive unpacks to more than {MOST_TEXT_BYTES // 1_000_000} MB."
        )
    return data
