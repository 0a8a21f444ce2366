"""Boards by URL: the software model, the simulated board, or hardware on any serial port."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from urllib.parse import parse_qsl

from pathgene.hdl.config import Config, GeneticCore
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link, LinkTimeoutError
from pathgene.host.device.schemes import BoardScheme, registered_scheme
from pathgene.host.device.serial_port import SerialScheme
from pathgene.host.errors import InputError
from pathgene.host.old_words import current_url
from pathgene.host.stages import stage


__all__ = [
    "board_scheme",
    "entered",
    "kept_open",
    "known_config",
    "open_board",
    "require_chip",
    "url_of",
    "with_core",
]

_SERIAL = SerialScheme()
# Boards by URL that stay open for their next user; None outside `kept_open`.
_KEPT: ContextVar[dict[str, Chip] | None] = ContextVar("kept", default=None)


def board_scheme(url: str) -> BoardScheme:
    """Return the kind of the board at ``url``: a registered one, or a serial port.

    Raises
    ------
    InputError
        If ``url`` is not a string.
    """
    if not isinstance(url, str):
        raise InputError(f"The board must be a URL, not {url!r}.")
    return registered_scheme(url) or _SERIAL


def open_board(url: str) -> Chip:
    """Open the board at ``url``.

    Parameters
    ----------
    url : str
        ``model:``; ``sim:`` or ``sim:?sim=icarus``; a serial device; any URL of pyserial; a URL of
        any scheme that :mod:`pathgene.host.device.schemes` finds. ``model:`` and ``sim:`` take any
        field of :class:`pathgene.hdl.config.Config` as an option, as in ``sim:?max_waypoints=20``;
        a serial port takes ``?baud=``, which defaults to the rate of the configuration's divisor
        and clock. Serial ports and ``sim:`` take ``?patience=``, the seconds without an answer
        after which the board is given up.

    Raises
    ------
    InputError
        If there is no such device, an option is wrong, nothing answers, or the board has another
        protocol version or build.
    JobError
        If a simulated board cannot be started.
    """
    scheme = board_scheme(url)
    url = current_url(url)
    stage("opening the board")
    opened = scheme.open(url)
    try:
        link = Link(opened.port, timeout_s=opened.timeout_s, attempts=opened.attempts)
        return Chip(link, url=url)
    except LinkTimeoutError:
        opened.port.close()
        raise InputError(
            f"Nothing answers at {url!r} as a board would; check the address, the baud rate and "
            "that the board is configured."
        ) from None
    except BaseException:
        opened.port.close()
        raise


def url_of(board: str | Chip) -> str:
    """Return the URL of a board that is given as a URL or as an open board."""
    return board.url if isinstance(board, Chip) else board


def entered(
    board: str | Chip,
    opener: Callable[[str], AbstractContextManager[Chip]] | None = None,
    *,
    core: GeneticCore | None = None,
) -> AbstractContextManager[Chip]:
    """Return a context manager that yields an open board.

    An open board stays open. A closed board or a URL is opened by ``opener``, by default
    :func:`open_board`, and stays open within :func:`kept_open`. A simulated board gets the ``core``
    that a planner needs unless its URL names a core: if the board is already open, it gets a second
    chip, which is closed with it.

    Raises
    ------
    InputError, JobError
        As :func:`open_board`, and if a board that is not simulated lacks the core.
    """
    url = url_of(board)
    if not isinstance(board, Chip) or board.closed:
        wanted, kept = url if core is None else with_core(url, core), _KEPT.get()
        if opener is None and kept is not None:
            return _taken(wanted, kept)
        return (opener or open_board)(wanted)
    needed = url if core in (None, board.config.core) else with_core(url, str(core))
    return nullcontext(board if needed == url else board.beside(lambda: open_board(needed)))


@contextmanager
def kept_open() -> Iterator[None]:
    """Keep each board that :func:`entered` opens by its URL open until the end of the block.

    The next user gets the same open board, to which only changes of the map are sent. A board whose
    use ends with an error, or without an open session, is closed: its user may have noted the loss
    of the board without raising it.
    """
    boards: dict[str, Chip] = {}
    before = _KEPT.set(boards)
    try:
        yield
    finally:
        _KEPT.reset(before)
        for chip in boards.values():
            chip.close()


@contextmanager
def _taken(url: str, boards: dict[str, Chip]) -> Iterator[Chip]:
    """Yield the board at ``url``, which stays among ``boards`` unless it is lost."""
    chip = boards.pop(url, None)
    if chip is None or chip.closed:
        chip = open_board(url)
    try:
        yield chip
    except BaseException:
        chip.close()
        raise
    if chip.link.session is None:
        chip.close()
    else:
        boards[url] = chip


def known_config(url: str) -> Config | None:
    """Return the configuration of the board at ``url`` if the URL states it, otherwise None.

    Raises
    ------
    InputError
        If a value breaks a rule of the configuration.
    """
    return board_scheme(url).known_config(url)


def with_core(url: str, core: str) -> str:
    """Return the URL of a simulated board with the genetic core that a planner needs.

    A URL that names a core stays unchanged, and so does the URL of a board that is not simulated.

    Raises
    ------
    InputError
        If ``url`` is not a string.
    """
    scheme = board_scheme(url)
    url = current_url(url)
    place, _, query = url.partition("?")
    named = any(name == "core" for name, _ in parse_qsl(query, keep_blank_values=True))
    if named or not scheme.simulated:
        return url
    return f"{place}?{query}&core={core}" if query else f"{place}?core={core}"


def require_chip(config: Config, core: GeneticCore, population: int | None) -> None:
    """Refuse a chip that lacks the core that a planner needs, or has a different population.

    Raises
    ------
    InputError
        If the chip is refused; with ``population`` None, any population is accepted.
    """
    if config.core is GeneticCore.NONE:
        raise InputError(
            "This board has no genetic core, it only checks paths; use another board, "
            "or the planner ga-pc."
        )
    if config.core is not core and core is GeneticCore.PLANNER:
        raise InputError(
            "This board has no planner core, so it does not plan by itself; use another board, or "
            "the planner ga-fpga."
        )
    if config.core is not core:
        raise InputError(
            "This board has the planner core, which breeds without the host; use another board, or "
            "the planner ga-chip."
        )
    if population not in (None, config.population):
        raise InputError(
            f"The population of this board is {config.population}, not {population}; leave the "
            "population out (--population) or use another board."
        )
