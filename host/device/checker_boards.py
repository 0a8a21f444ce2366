"""Boards with the collision checker that a mode needs."""

from __future__ import annotations

from urllib.parse import parse_qsl, urlencode

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.host.device.boards import board_scheme
from pathgene.host.device.checker_modes import MODES
from pathgene.host.errors import InputError


__all__ = ["order_board", "require_checker"]


def order_board(url: str, mode: str | None) -> tuple[str, Config | None]:
    """Return the URL of the board that a mode needs, and its configuration.

    Parameters
    ----------
    url : str
        As for :func:`pathgene.host.device.boards.open_board`. Simulated boards, such as ``model:``
        and ``sim:``, are built for the mode unless their URL sets ``checker`` and ``lanes``. Other
        boards have the checker that they were built with.
    mode : str or None
        One of :data:`pathgene.host.device.checker_modes.MODES`. None selects the build that the URL
        names, by default ``two-tier``.

    Returns
    -------
    tuple of (str, Config or None)
        The URL to open, and the board's configuration; None if only the board knows it.

    Raises
    ------
    InputError
        If an option of the URL breaks a rule of the configuration, or does not suit the mode.
    """
    scheme = board_scheme(url)
    if not scheme.simulated:
        return url, None
    place, _, query = url.partition("?")
    given = dict(parse_qsl(query, keep_blank_values=True))
    wanted = MODES.get(mode or given.get("checker", next(iter(MODES))), {})
    order = f"{place}?{urlencode(wanted | given)}"
    config = scheme.known_config(order)
    if config is not None:
        require_checker(config, mode, url)
    return order, config


def require_checker(config: Config, mode: str | None, url: str) -> None:
    """Refuse a board without the checker that ``mode`` needs.

    Raises
    ------
    InputError
        If the board is refused.
    """
    if config.checker is CheckerBuild.NONE:
        raise InputError(
            f"The board at {url!r} has no collision checker; use a bitstream with one, or model:."
        )
    if config.planner_core:
        raise InputError(
            f"The board at {url!r} has the planner core, which checks the paths that it breeds and "
            "no others; use a board with another core, or model:."
        )
    wanted = MODES[mode] if mode else {}
    if any(getattr(config, name) != value for name, value in wanted.items()):
        lanes = f"{config.lanes} lane" + "s" * (config.lanes > 1)
        raise InputError(
            f"The board at {url!r} has the {config.checker} checker of {lanes}, which does not "
            f"serve --mode {mode}; leave --mode out."
        )
