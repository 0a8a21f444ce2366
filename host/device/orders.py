"""Commands whose answers carry no payload, sent one by one or in batches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import TracebackType

from pathgene.host.device.link import Link


__all__ = ["Orders"]

#: Maximum number of commands sent at once: as many as a link has in flight.
_MOST = 64


def _nothing() -> None:
    pass


class Orders:
    """Sends a chip commands whose answers carry no payload; a batch waits once for all of them.

    Raises
    ------
    LinkError
        From every method, as :meth:`pathgene.host.device.link.Link.order` does. Commands given
        :meth:`together` raise it when they are sent.
    """

    def __init__(self, link: Link) -> None:
        self._link = link
        self._batch: _Batch | None = None

    def together(self, meanwhile: Callable[[], object] = _nothing) -> _Batch:
        """Return a context that collects commands and sends them when it ends.

        A full batch of 64 is sent early. The context must not send any other request. When the
        last commands have been sent, ``meanwhile`` is called, before the wait for their answers.
        """
        return _Batch(self, self._link, meanwhile)

    def enter(self, batch: _Batch | None) -> None:
        """Collect further commands in ``batch``, or send them directly if it is None."""
        self._batch = batch

    def give(
        self,
        commands: Sequence[tuple[int, bytes]],
        *,
        lost: Callable[[], object] = _nothing,
        then: Callable[[], object] = _nothing,
    ) -> None:
        """Have commands executed exactly once, in order.

        Parameters
        ----------
        lost : callable
            Called if it remains unknown whether the chip has executed them.
        then : callable
            Called once they are executed or added to the batch.
        """
        batch = _Batch(self, self._link) if self._batch is None else self._batch
        try:
            batch.add(commands, lost)
            if batch is not self._batch or len(batch) >= _MOST:
                batch.send()
            then()
        except BaseException:
            batch.forget()
            raise


class _Batch:
    """Commands to send together, and the functions to call if they are lost."""

    def __init__(
        self, orders: Orders, link: Link, meanwhile: Callable[[], object] = _nothing
    ) -> None:
        self._orders, self._link, self._meanwhile = orders, link, meanwhile
        self._commands: list[tuple[int, bytes]] = []
        self._lost: list[Callable[[], object]] = []

    def __len__(self) -> int:
        return len(self._commands)

    def __enter__(self) -> None:
        self._orders.enter(self)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        try:
            if kind is None:
                self.send(self._meanwhile)
        finally:
            self._orders.enter(None)
            self.forget()

    def add(self, commands: Sequence[tuple[int, bytes]], lost: Callable[[], object]) -> None:
        """Add commands."""
        self._lost.append(lost)
        self._commands += commands

    def send(self, meanwhile: Callable[[], object] = _nothing) -> None:
        """Send all commands, and wait until the chip has executed them."""
        if self._commands:
            self._link.order(self._commands, meanwhile)
        self._commands.clear()
        self._lost.clear()

    def forget(self) -> None:
        """Drop all commands, and report each as lost."""
        try:
            self._tell()
        except BaseException:
            # Even after an interrupt, the remaining losses must be reported.
            self._tell()
            raise

    def _tell(self) -> None:
        self._commands.clear()
        while self._lost:
            self._lost[-1]()
            self._lost.pop()
