"""Progress of a run on standard error: a line on a terminal, occasional lines in a log."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any, TextIO

from pathgene.host.stages import current_part


if TYPE_CHECKING:
    from tqdm.std import tqdm

__all__ = ["Bar", "Counter", "Progress", "beside_bars"]

_BAR_PERIOD_S = 0.1
_LOG_PERIOD_S = 5.0
# Columns of a terminal that does not know them.
_COLUMNS = 80
# Minimum seconds of a stage whose name and time stay on the terminal.
_NOTABLE_S = 0.5
_FORM = "{percentage:3.0f} % |{bar:10}| {desc}, {remaining} left"
_FORM_OF_UNKNOWN = "{desc}, {elapsed}"


class Bar:
    """A progress line with a text, and with stages that have a name.

    Parameters
    ----------
    stream : TextIO
        A terminal, which shows one line with a bar and the time left, or any other stream, which
        gets whole lines: the first text, one every 5 seconds, and the last text. Stages have lines
        of their own in a log only if no other line has appeared for 5 seconds.
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
        # When the first stage of a log began.
        self._began_s: float | None = None
        self._pending: str | None = None
        self._last = ""
        self._line: tqdm[Any] | None = None
        # The stage whose line is open, or is the last in a log; None for the line of the text.
        self._stage: str | None = None
        self._stage_s = 0.0

    @property
    def shows_time_left(self) -> bool:
        """True at a terminal, where the line has the time left."""
        return self._terminal

    def show(self, done: int, text: str) -> None:
        """Show ``text`` next to the bar, or delay it if the previous one is recent."""
        now = self._clock()
        self._last = text = _in_part(text)
        if self._terminal:
            self._draw(None, self._total, min(done, self._total), text, now)
            return
        if self._shown_s is not None and now - self._shown_s < _LOG_PERIOD_S:
            self._pending = text
            return
        self._write(text, now)

    def stage(self, name: str, share: float | None = None) -> None:
        """Show a stage, and the share of it that is done, 0..1, if known."""
        now, name = self._clock(), _in_part(name)
        if self._terminal:
            if share is None:
                self._draw(name, None, 0, name, now)
            else:
                self._draw(name, 100, round(100 * share), name, now)
            return
        if share is None and name == self._stage:
            return
        if self._began_s is None:
            self._began_s = now
        if now - (self._began_s if self._shown_s is None else self._shown_s) >= _LOG_PERIOD_S:
            self._stage = name
            if self._pending is not None:
                self._write(self._pending, now)
            self._write(name if share is None else f"{name} {100 * share:.0f} %", now)

    def close(self) -> None:
        """Show the last text, and end the line."""
        if self._terminal:
            self._end_line(self._clock())
            if self._last:
                self._stream.write(f"{self._last}\n")
                self._stream.flush()
        elif self._pending is not None:
            self._write(self._pending, self._shown_s)
        self._last = ""

    def _write(self, text: str, now: float | None) -> None:
        self._pending = None
        self._stream.write(f"{text}\n")
        self._stream.flush()
        self._shown_s = now

    def _draw(self, stage: str | None, total: int | None, done: int, text: str, now: float) -> None:
        """Draw the line of a stage, or of the text; lines that follow each other fast are left out.

        Parameters
        ----------
        total : int or None
            None if the share that is done is unknown.
        """
        # Loaded only at a terminal.
        from tqdm.std import tqdm

        line = self._line
        if line is None or stage != self._stage or total != line.total or done < line.initial:
            self._end_line(now)
            # Without a thread that watches for bars that are not updated.
            tqdm.monitor_interval = 0
            form = _FORM_OF_UNKNOWN if total is None else _FORM
            self._line = tqdm(
                desc=text,
                total=total,
                initial=done,
                file=self._stream,
                leave=False,
                ncols=_columns(self._stream),
                # It asks a terminal that does not know its size, and shows nothing if that is 0.
                nrows=2,
                bar_format=form,
            )
            self._stage, self._stage_s, self._shown_s = stage, now, now
            return
        if self._shown_s is not None and now - self._shown_s < _BAR_PERIOD_S:
            return
        line.n = done
        line.set_description_str(text, refresh=False)
        line.refresh()
        self._shown_s = now

    def _end_line(self, now: float) -> None:
        """Remove the line; the name and the time of a stage that was long stay."""
        if self._line is None:
            return
        self._line.close()
        self._line = None
        spent_s = now - self._stage_s
        if self._stage is not None and spent_s >= _NOTABLE_S:
            self._stream.write(f"{self._stage}: {spent_s:.1f} s\n")
            self._stream.flush()


def _columns(stream: TextIO) -> int:
    """Return the columns of a terminal; a usual number if it does not know them."""
    try:
        return os.get_terminal_size(stream.fileno()).columns or _COLUMNS
    except OSError:  # Also of a stream without a file.
        return _COLUMNS


def _in_part(text: str) -> str:
    return f"{name}: {text}" if (name := current_part()) else text


def beside_bars() -> AbstractContextManager[object]:
    """Return a context that removes an open line of a bar, and draws it again at its end."""
    # Loaded only if a bar has been drawn.
    if (loaded := sys.modules.get("tqdm.std")) is None:
        return nullcontext()
    context: AbstractContextManager[object] = loaded.tqdm.external_write_mode(file=sys.stderr)
    return context


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
