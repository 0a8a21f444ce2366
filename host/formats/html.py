"""The page of a plan, which :mod:`pathgene.host.web.page` makes."""

from __future__ import annotations

from pathgene.host.formats.track import Track


__all__ = ["write"]


def write(track: Track) -> bytes:
    """Return the page.

    Raises
    ------
    ValueError
        If the track has no function for the page.
    """
    if track.page is None:
        raise ValueError("The format html needs the function that makes the page")
    return track.page().encode()
