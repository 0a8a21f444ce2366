"""Commands whose answers say nothing, one after the other or many at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from host.device.link import Link


__all__ = ["Orders"]

#: Commands sent at once at most: as many as a link has in flight.
_MOST = 64


def _nothing() -> None:
    pass


class Orders:
    """Gives a chip commands whose answers say nothing; several share one wait for a reply.

    Parameters
    ----------
    link : Link
        Link to the chip.

    Raises
    ------
    LinkError
        From every method, as :meth:`host.device.link.Link.order` does. Commands given
        :meth:`together` raise it when they are sent.
    """

    def __init__(self, link: Link) -> None:
        self._link = link
        self._is_together = False
        self._commands: list[tuple[int, bytes]] = []
        self._lost: list[Callable[[], object]] = []

    @contextmanager
    def together(self) -> Iterator[None]:
        """Within this context commands wait for each other; no other request may come between.

        They are sent at its end. Where there are many, some are sent before.
        """
        self._is_together = True
        try:
            yield
            self._send()
        finally:
            self._is_together = False
            self._forget()

    def give(
        self,
        commands: Sequence[tuple[int, bytes]],
        *,
        lost: Callable[[], object] = _nothing,
        then: Callable[[], object] = _nothing,
    ) -> None:
        """Have commands executed once each, in their order.

        Parameters
        ----------
        commands : sequence of (int, bytes)
            Code and payload of each.
        lost : callable
            Called if it is unknown in the end whether the chip has executed them.
        then : callable
            Called once the chip has executed them, or will have: they are sent with others.
        """
        try:
            self._lost.append(lost)
            self._commands += commands
            if not self._is_together or len(self._commands) >= _MOST:
                self._send()
            then()
        finally:
            if not self._is_together:
                self._forget()

    def _send(self) -> None:
        if self._commands:
            self._link.order(self._commands)
        self._commands.clear()
        self._lost.clear()

    def _forget(self) -> None:
        """Forget all commands; those that were not confirmed are lost."""
        self._commands.clear()
        while self._lost:
            self._lost[-1]()
            self._lost.pop()
