"""Files of zones: GeoJSON, KML and the plans of QGroundControl, told apart by their content."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.inputs import parse_json, read_text
from pathgene.host.problem.geojson import Shape, shapes
from pathgene.host.problem.kml import kml_shapes
from pathgene.host.problem.qgc_fences import fence_shapes
from pathgene.host.terrain import Terrain


__all__ = ["document_shapes", "read_document"]


def read_document(path: str | Path) -> Any:
    """Return the text of a KML file, or the content of a JSON file.

    Raises
    ------
    InputError
        If the file cannot be read or is neither.
    """
    try:
        text = read_text(Path(path), "utf-8-sig")
    except OSError as error:
        reason = error.strerror or "unknown reason"
        raise InputError(f"Cannot read no-fly file {str(path)!r}: {reason}.") from None
    except UnicodeDecodeError:
        is_kmz = str(path).lower().endswith(".kmz")
        why = "a KMZ archive; unzip it and give the .kml in it" if is_kmz else "not text in UTF-8"
        raise InputError(f"No-fly file {str(path)!r} is {why}.") from None
    if text.lstrip().startswith("<"):
        return text
    try:
        return parse_json(text)
    except ValueError as error:
        raise InputError(f"No-fly file {str(path)!r} is not JSON: {error}.") from None


def document_shapes(document: Any, terrain: Terrain) -> Iterable[Shape]:
    """Return the zones of a document as points and polygons in the terrain's local frame.

    See :func:`pathgene.host.problem.kml.kml_shapes`,
    :func:`pathgene.host.problem.qgc_fences.fence_shapes` and
    :func:`pathgene.host.problem.geojson.shapes`, also for the errors.
    """
    if isinstance(document, str):
        return kml_shapes(document, terrain)
    if isinstance(document, dict) and document.get("fileType") == "Plan":
        return fence_shapes(document, terrain)
    return shapes(document, terrain)
