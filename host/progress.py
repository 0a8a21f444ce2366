"""Progress of a run on standard error: a bar on a terminal, occasional lines in a log."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TextIO


__all__ = ["Bar", "Counter", "Progress"]

_BAR_WIDTH = 30
_BAR_PERIOD_S = 0.1
_LOG_PERIOD_S = 5.0


class Bar:
    """A progress bar with a text.

    Parameters
    ----------
    stream : TextIO
        A terminal, which shows one line that is redrawn, or any other stream, which gets whole
        lines: the first one, one every 5 seconds, and the last one.
    total : int
        Amount that fills the bar, 1 or more.
    clock : callable
        Returns seconds.
    """

    def __init__(
        self, stream: TextIO, total: int, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._stream = stream
        self._total = total
        self._clock = clock
        self._terminal = stream.isatty()
        self._shown_s: float | None = None
        self._pending: str | None = None
        self._open_line = False

    def show(self, done: int, text: str) -> None:
        """Show ``text`` next to the bar, or delay it if the previous one is recent."""
        now = self._clock()
        period = _BAR_PERIOD_S if self._terminal else _LOG_PERIOD_S
        if self._terminal:
            full = min(_BAR_WIDTH, _BAR_WIDTH * done // self._total)
            text = f"[{'#' * full}{'.' * (_BAR_WIDTH - full)}] {text}"
        if self._shown_s is not None and now - self._shown_s < period:
            self._pending = text
            return
        self._write(text)
        self._shown_s = now

    def close(self) -> None:
        """Show the last text if it was delayed, and end the line."""
        if self._pending is not None:
            self._write(self._pending)
        if self._open_line:
            self._stream.write("\n")
            self._stream.flush()
            self._open_line = False

    def _write(self, text: str) -> None:
        self._pending = None
        if self._terminal:
            self._stream.write(f"\r\x1b[K{text}")
            self._open_line = True
        else:
            self._stream.write(f"{text}\n")
        self._stream.flush()


class Progress(Bar):
    """A :class:`Bar` over a number of ``generations``, 1 or more."""

    def __init__(
        self, stream: TextIO, generations: int, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(stream, generations, clock)
        self._generations = generations

    def update(self, generation: int, best: float, mean: float) -> None:
        """Show a finished generation, or delay it if the previous one is recent."""
        # Some planners run again if they find nothing.
        of = f"/{self._generations}" if generation <= self._generations else ""
        self.show(generation, f"generation {generation}{of}  best {best:.4f}  mean {mean:.4f}")


class Counter:
    """A growing number on a terminal, whose end is unknown; on any other stream nothing.

    Parameters
    ----------
    text : str
        The things counted.
    """

    def __init__(self, stream: TextIO, text: str) -> None:
        self._stream = stream
        self._text = text
        self._terminal = stream.isatty()
        self._open_line = False

    def update(self, done: int) -> None:
        """Show the number."""
        if self._terminal:
            self._stream.write(f"\r\x1b[K{done} {self._text}")
            self._stream.flush()
            self._open_line = True

    def close(self) -> None:
        """End the line."""
        if self._open_line:
            self._stream.write("\n")
            self._stream.flush()
            self._open_line = False
