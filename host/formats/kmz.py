"""KMZ: an archive with KML documents; the main one is ``doc.kml`` or the first ``.kml``.

Every document of the archive is read, because the main one may show zones of further documents by
links.
"""

from __future__ import annotations

import io
import posixpath
import zipfile
import zlib
from collections.abc import Collection, Iterator
from urllib.parse import unquote
from xml.etree import ElementTree as ET

from pathgene.host.errors import InputError
from pathgene.host.formats import kml
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, LeftOut, Read
from pathgene.host.inputs import MOST_TEXT_BYTES


__all__ = ["features", "recognises"]

# Maximum number of files in an archive; overlays may have hundreds of pictures.
_MOST_FILES = 10_000
_MOST_TEXT = f"{MOST_TEXT_BYTES // 1_000_000} MB"


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
    """Yield the areas of the documents, the main one first.

    A document that is broken, or that would make the archive unpack to more than the maximum size
    of a text, is bad. An archive in the archive is left out and named.

    Raises
    ------
    InputError
        If the archive is broken or has no KML document, if the main document is broken, encrypted
        or too large, or if there is no area.
    """
    return kml.with_areas(_parts(content))


def _parts(content: Content) -> Iterator[Read]:
    with _opened(content) as archive:
        names = _documents(archive)
        if not names:
            raise InputError("the archive has no .kml document.")
        main, *others = names
        root = kml.document_of(Content(_unpacked(archive, main), main))
        yield from kml.parts(root, "", _links_inside(root, main, names))
        left = MOST_TEXT_BYTES - archive.getinfo(main).file_size
        for name in others:
            try:
                # An archive unpacks no more of a document than the size that it states.
                left -= archive.getinfo(name).file_size
                if left < 0:
                    raise InputError(f"the documents unpack to more than {_MOST_TEXT} with it.")
                root = kml.document_of(Content(_unpacked(archive, name), name))
            except InputError as error:
                yield Bad(f"{name!r} in the archive", _without(name, str(error)))
                continue
            yield from kml.parts(root, f"{name}: ", _links_inside(root, name, names))
        for name in archive.namelist():
            if name.lower().endswith(".kmz"):
                reason = "an archive in an archive is not read; give it as a file of its own"
                yield LeftOut(f"{name!r} in the archive", reason, True)


def _without(name: str, reason: str) -> str:
    """Return the reason without the name of the document, which the label has."""
    return reason.replace(f"{name!r} in the archive", "it")


def _links_inside(root: ET.Element, name: str, names: Collection[str]) -> list[ET.Element]:
    """Return the links of a document to documents of the archive."""
    known = {each.lower() for each in names}
    folder = posixpath.dirname(name)
    return [
        link
        for link, address in kml.links_of(root)
        if posixpath.normpath(posixpath.join(folder, unquote(address))).lower() in known
    ]


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
        raise InputError(f"{name!r} in the archive unpacks to more than {_MOST_TEXT}.")
    return data
