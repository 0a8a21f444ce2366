"""The chip that the URL of a simulated board or of the software model describes."""

from __future__ import annotations

from urllib.parse import parse_qsl, urlencode

from pathgene.hdl.config import Config
from pathgene.host.device.schemes import split_config
from pathgene.host.errors import InputError
from pathgene.sim import DEFAULT_CONFIG


__all__ = ["PORT", "chip_of"]

#: Option of a URL: the port of the chip, one of these words.
PORT = "port"
_BYTES, _UART = "bytes", "uart"


def chip_of(url: str) -> tuple[str, Config]:
    """Remove the fields of the configuration and the option ``port`` from the query of ``url``.

    A chip with the planner core has a byte-wide port, unless ``port=uart`` or a divisor of the UART
    is given; any other chip has the UART of *allaire-2008*, unless ``port=bytes`` is given.

    Returns
    -------
    tuple of (str, Config)
        The rest of the URL, and the configuration of the chip.

    Raises
    ------
    InputError
        If a value breaks a rule of the configuration, or contradicts the port.
    """
    rest, config = split_config(url, DEFAULT_CONFIG)
    place, _, query = rest.partition("?")
    pairs = parse_qsl(query, keep_blank_values=True)
    ports = [value for name, value in pairs if name == PORT]
    given = dict(parse_qsl(url.partition("?")[2]))
    has_divisor = "clocks_per_bit" in given
    if ports:
        port = ports[0]
        if len(ports) > 1 or port not in (_BYTES, _UART):
            raise InputError(
                f"Option {PORT} of a simulated chip must be {_BYTES} or {_UART}, given once, not "
                f"{' and '.join(map(repr, ports))}."
            )
        if has_divisor and config.has_uart == (port == _BYTES):
            raise InputError(
                f"{PORT}={port} contradicts clocks_per_bit={given['clocks_per_bit']}; leave one of "
                "them out."
            )
    else:
        port = _BYTES if config.planner_core and not has_divisor else _UART
    if port == _BYTES and not has_divisor:
        config = config.replace(clocks_per_bit=0)
    kept = [pair for pair in pairs if pair[0] != PORT]
    return (f"{place}?{urlencode(kept)}" if kept else place), config
