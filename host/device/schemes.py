"""Board URLs: kinds of boards, each found by the scheme of its URLs.

A package makes a kind of board known by an entry point of the group ``pathgene.boards``. The name
of the entry point is the scheme, its object a :class:`BoardScheme`::

    [project.entry-points."pathgene.boards"]
    probe = "probe_boards:SCHEME"

From then on ``pathgene plan --board probe:...`` opens these boards. A URL of any other scheme
names a serial port.
"""

from __future__ import annotations

import abc
import dataclasses
from dataclasses import dataclass
from typing import Protocol, Self
from urllib.parse import parse_qsl, urlencode

from pathgene.hdl.config import Config
from pathgene.host.device.transport import Transport
from pathgene.host.entry_points import entry_points
from pathgene.host.errors import InputError, JobError
from pathgene.host.numeric import parse, whole
from pathgene.host.old_words import current_url


__all__ = [
    "CONFIG_FIELDS",
    "GROUP",
    "MAXIMUM_PATIENCE_S",
    "PATIENCE_S",
    "BoardScheme",
    "OpenPort",
    "ServedBoard",
    "parse_patience",
    "registered_scheme",
    "scheme_names",
    "split_config",
]

#: Group of the entry points that name kinds of boards.
GROUP = "pathgene.boards"

#: Seconds that a host waits for an answer before it gives up on the board; only simulations, which
#: are a thousand times slower, have more.
PATIENCE_S = 15.0
#: Maximum patience that a URL may set, seconds.
MAXIMUM_PATIENCE_S = 86_400

#: Names of the fields of the configuration, which are options of boards that are built to order.
CONFIG_FIELDS = tuple(field.name for field in dataclasses.fields(Config))


@dataclass(frozen=True)
class OpenPort:
    """An open port to a board, and the patience that a link needs with that board.

    Parameters
    ----------
    port : Transport
        The port. Closing it ends a board that was started for it.
    timeout_s : float
        Longest silence of the board, in seconds, before a frame is sent again.
    attempts : int
        Number of times that a frame is sent before the link gives up on the board.
    """

    port: Transport
    timeout_s: float
    attempts: int


class ServedBoard(Protocol):
    """A simulated board that runs and waits for serial clients.

    Attributes
    ----------
    url : str
        The address that clients open: a URL of pyserial, or the path of a terminal.
    """

    url: str

    @property
    def pid(self) -> int:
        """Process of the simulator."""
        ...

    def wait(self, timeout_s: float | None = None) -> int | None:
        """Wait for the end of the simulator; return its exit status, or None after the time-out."""
        ...

    def log(self) -> str:
        """Return the text that the simulator wrote to standard error."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(self, *error: object) -> None: ...


class BoardScheme(abc.ABC):
    """A kind of board, named by the scheme of its URLs.

    Attributes
    ----------
    simulated : bool
        True for boards that are built as their URLs say, for a single user. Hardware has its
        configuration already and is shared.
    """

    simulated = False

    @abc.abstractmethod
    def open(self, url: str) -> OpenPort:
        """Open a port to the board at ``url``.

        Raises
        ------
        InputError
            If there is no such board, or an option of the URL is wrong.
        JobError
            If a simulated board cannot be started.
        """

    def known_config(self, url: str) -> Config | None:
        """Return the configuration of the board at ``url``, or None if only the board knows it.

        Raises
        ------
        InputError
            If an option breaks a rule of the configuration.
        """
        return None

    def serve(self, url: str, *, listen: str, pty: bool) -> ServedBoard:
        """Start the board at ``url`` for any serial client, one after another.

        Parameters
        ----------
        listen : str
            ``HOST:PORT`` to listen at; port 0 takes a free one.

        Raises
        ------
        InputError
            If boards of this kind cannot be served, or an option of the URL is wrong.
        JobError
            If the board cannot be started.
        """
        raise InputError(
            f"Only a simulated board can be served, sim: or model: with its options, not {url!r}."
        )


def registered_scheme(url: str) -> BoardScheme | None:
    """Return the registered kind of board that ``url`` names, or None if there is none.

    Raises
    ------
    JobError
        If the package that registers the scheme cannot be loaded.
    """
    name, colon, _ = url.partition(":")
    point = next((point for point in entry_points(GROUP) if colon and point.name == name), None)
    if point is None:
        return None
    try:
        scheme: BoardScheme = point.load()
    except (ImportError, AttributeError) as error:
        raise JobError(f"Boards of the scheme {name}: cannot be loaded ({error}).") from None
    return scheme


def scheme_names() -> list[str]:
    """Return the names of all registered schemes."""
    return list(dict.fromkeys(point.name for point in entry_points(GROUP)))


def _value(text: str) -> int | str:
    """Return the number in a text, or the text itself, which the configuration checks."""
    try:
        return whole(text)
    except ValueError:
        return text


def parse_patience(text: str) -> float | None:
    """Return the seconds of the option ``patience`` of a URL, or None if ``text`` has none."""
    try:
        seconds = parse(text)
    except ValueError:
        return None
    return seconds if 0 < seconds <= MAXIMUM_PATIENCE_S else None


def split_config(url: str, default: Config) -> tuple[str, Config]:
    """Remove the fields of the configuration from the query of ``url``.

    Returns
    -------
    tuple of (str, Config)
        The URL without the fields, and ``default`` updated by them.

    Raises
    ------
    InputError
        If a value breaks a rule of the configuration.
    """
    place, _, query = current_url(url).partition("?")
    changes: dict[str, object] = {}
    rest = []
    for name, value in parse_qsl(query, keep_blank_values=True):
        if name in CONFIG_FIELDS:
            changes[name] = _value(value)
        else:
            rest.append((name, value))
    try:
        config = default.replace(**changes)
    except (TypeError, ValueError) as error:
        raise InputError(f"{error}; see the options in {url!r}.") from None
    return (f"{place}?{urlencode(rest)}" if rest else place), config
