"""Boards that check paths as a mode asks for."""

from __future__ import annotations

from urllib.parse import parse_qsl, urlencode

from hdl.config import CheckerBuild, Config
from host.device.boards import board_scheme
from host.errors import InputError
from host.feasibility import MODES


__all__ = ["ordered", "require"]


def ordered(url: str, mode: str | None) -> tuple[str, Config | None]:
    """Order the board that a mode asks for.

    Parameters
    ----------
    url : str
        As for :func:`host.device.boards.open_board`. ``model:`` and ``sim:`` are built for the
        mode, unless they name a ``checker`` and ``lanes`` themselves; other boards are what they
        are.
    mode : str or None
        One of :data:`host.feasibility.MODES`; None for what the URL names, by default ``two-tier``.

    Returns
    -------
    tuple of (str, Config or None)
        The URL to open, and the configuration that it will have; None where the board must tell.

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
    assert config is not None
    require(config, mode, url)
    return order, config


def require(config: Config, mode: str | None, url: str) -> None:
    """Refuse a board that has no checker, or not the one of ``mode``.

    Raises
    ------
    InputError
        If so.
    """
    if config.checker is CheckerBuild.NONE:
        raise InputError(
            f"The board at {url!r} has no collision checker; use a bitstream with one, or model:."
        )
    wanted = MODES[mode] if mode else {}
    if any(getattr(config, name) != value for name, value in wanted.items()):
        lanes = f"{config.lanes} lane" + "s" * (config.lanes > 1)
        raise InputError(
            f"The board at {url!r} has the {config.checker} checker of {lanes}, which does not "
            f"serve --mode {mode}; leave --mode out."
        )
