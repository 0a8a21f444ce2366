"""Entry points of this project and of installed packages."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path


__all__ = ["entry_points"]


def entry_points(group: str) -> Iterator[metadata.EntryPoint]:
    """Yield the entry points of the checkout, then the entry points of installed packages.

    An editable installation keeps the entry points from the time of installation. In a checkout,
    ``pyproject.toml`` is up to date.
    """
    declared = Path(__file__).resolve().parents[1] / "pyproject.toml"
    if declared.is_file():
        project = tomllib.loads(declared.read_text("utf-8")).get("project", {})
        # The file next to an installed package may belong to another project.
        if project.get("name") == "pathgene":
            for name, value in project.get("entry-points", {}).get(group, {}).items():
                yield metadata.EntryPoint(name, value, group)
    yield from metadata.entry_points(group=group)
