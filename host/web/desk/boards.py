"""The boards that a page of the desk is allowed to name."""

from __future__ import annotations

from urllib.parse import parse_qsl

from pathgene.host.device.boards import known_config
from pathgene.host.device.schemes import CONFIG_FIELDS
from pathgene.host.errors import InputError


__all__ = ["require_board"]

# Options of a URL by its scheme. The option `trace` of `sim:` writes a file.
_OPTIONS = {
    "model:": frozenset((*CONFIG_FIELDS, "port")),
    "sim:": frozenset((*CONFIG_FIELDS, "port", "sim", "idle_clocks", "patience")),
}


def require_board(url: str | None, own: str | None) -> None:
    """Check a board that a page, a link or a file in a browser names.

    The name may come from somebody else, so it must not open a device, reach an address or write a
    file.

    Parameters
    ----------
    url : str, optional
        The board; None stands for the default board.
    own : str, optional
        The board of the problem file that the user started the desk with, which is allowed.

    Raises
    ------
    InputError
        If the board is not allowed, or an option breaks a rule of the configuration.
    """
    if url is None or url == own:
        return
    place, _, query = url.partition("?")
    names = {name for name, _ in parse_qsl(query, keep_blank_values=True)}
    if place not in _OPTIONS:
        raise InputError(
            f"The board of a page is model: or sim: with options, not {url!r}; start the desk with "
            "a problem file that names another board."
        )
    if refused := sorted(names - _OPTIONS[place]):
        raise InputError(
            f"The board of a page takes no option {refused[0]!r} ({url!r}); start the desk with a "
            "problem file that names this board."
        )
    known_config(url)
