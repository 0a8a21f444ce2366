"""Addresses that a command listens at."""

from __future__ import annotations

import ipaddress
import socket


__all__ = ["is_local"]


def is_local(host: str) -> bool:
    """Return whether a server at ``host`` can only be reached from this machine.

    Raises
    ------
    OSError
        If there is no such address.
    """
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        address = ipaddress.ip_address(socket.gethostbyname(host))
    return address.is_loopback
