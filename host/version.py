"""The version of the installed package."""

from __future__ import annotations

from importlib import metadata


__all__ = ["version"]


def version() -> str:
    """Version of the installed package."""
    try:
        return metadata.version("pathgene")
    except metadata.PackageNotFoundError:
        return "unknown"
