"""How far a run is, on standard error: a bar on a terminal, a line now and then in a log."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TextIO


__all__ = ["Progress"]

_BAR_WIDTH = 30
_BAR_PERIOD_S = 0.1
_LOG_PERIOD_S = 5.0


class Progress:
    """Shows generations as they pass.

    Parameters
    ----------
    stream : TextIO
        A terminal, where one line is drawn again and again, or anything else, which gets whole
        lines: the first generation, one every 5 seconds, and the last.
    generations : int
        How many make the bar full, 1 or more.
    clock : callable
        Returns seconds.
    """

    def __init__(
        self, stream: TextIO, generations: int, clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._stream = stream
        self._generations = generations
        self._clock = clock
        self._terminal = stream.isatty()
        self._shown_s: float | None = None
        self._pending: str | None = None
        self._open_line = False

    def update(self, generation: int, best: float, mean: float) -> None:
        """Show a finished generation, unless the last was shown a moment ago."""
        now = self._clock()
        text = (f"generation {generation}/{self._generations}  best {best:.4f}  mean {mean:.4f}")
        period = _BAR_PERIOD_S if self._terminal else _LOG_PERIOD_S
        if self._terminal:
            text = f"{self._bar(generation)} {text}"
        if self._shown_s is not None and now - self._shown_s < period:
            self._pending = text
            return
        self._show(text)
        self._shown_s = now

    def close(self) -> None:
        """Show the last generation if it was held back, and end the line."""
        if self._pending is not None:
            self._show(self._pending)
        if self._open_line:
            self._stream.write("\n")
            self._stream.flush()
            self._open_line = False

    def _bar(self, generation: int) -> str:
        full = min(_BAR_WIDTH, _BAR_WIDTH * generation // self._generations)
        return f"[{'#' * full}{'.' * (_BAR_WIDTH - full)}]"

    def _show(self, text: str) -> None:
        self._pending = None
        if self._terminal:
            self._stream.write(f"\r\x1b[K{text}")
            self._open_line = True
        else:
            self._stream.write(f"{text}\n")
        self._stream.flush()
