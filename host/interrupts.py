"""Signals that request the end of a process, including Ctrl-C, all with the same effect."""

from __future__ import annotations

import contextlib
import math
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from importlib.machinery import ExtensionFileLoader
from types import FrameType


__all__ = ["caught", "held", "instead", "kept_from_children", "status"]

#: Signals that request the end of a process.
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)

# Signals that child processes do not receive. A pool ends its processes with SIGTERM.
_KEPT_FROM_CHILDREN = frozenset(SIGNALS) - {signal.SIGTERM}
# One request can arrive twice: `timeout` signals its command, then the group of its command.
_REPEAT_S = 0.1
# Time after which a lost or delayed interrupt is raised again.
_AGAIN_S = 0.01
# An extension module that is not initialised after this time is interrupted nevertheless.
_INITIALISED_S = 1.0
_INITIALISATION = {
    method.__code__
    for method in (ExtensionFileLoader.create_module, ExtensionFileLoader.exec_module)
}


class _Received:
    """The signals since the process started to catch them."""

    first: int | None = None
    last: int = signal.SIGINT
    last_s = -1.0
    #: End of the delay of an interrupt; infinite if none is delayed.
    due_s = math.inf
    #: Raises the last interrupt again.
    timer: threading.Timer | None = None


def status(default: int = 128 + signal.SIGINT) -> int:
    """Return the exit status of an interrupted command: 128 + the number of the first signal.

    ``default`` is the status without a signal.
    """
    return default if _Received.first is None else 128 + _Received.first


@contextlib.contextmanager
def caught() -> Iterator[None]:
    """Raise :class:`KeyboardInterrupt` in the block at each signal that was not ignored.

    CPython drops an exception of a destructor or of a callback of a weak reference, which every
    import runs. An interrupt that is lost there is raised again. While an extension module is
    initialised, an interrupt is delayed, for at most a second: the module would turn it into an
    ``ImportError``.
    """
    if not _in_main_thread():
        yield
        return
    _Received.first, _Received.last_s, _Received.due_s = None, -1.0, math.inf
    usual = (signal.SIG_DFL, signal.default_int_handler)
    ours = [number for number in SIGNALS if signal.getsignal(number) in usual]
    try:
        with _handled(ours, _raise), _raised_again_if_lost():
            yield
    finally:
        if _Received.timer is not None:
            _Received.timer.cancel()
        # CPython remembers an interrupt that leaves exec(), which creates dataclasses, and ends
        # `python -m` with SIGINT although the interrupt was caught. The next exec() clears that
        # memory.
        exec("")


@contextlib.contextmanager
def instead(action: Callable[[], None]) -> Iterator[None]:
    """Call ``action`` at each signal in the block instead of the usual handler."""

    def handle(number: int, _frame: FrameType | None) -> None:
        if _accepted(number):
            action()

    with _handled(_caught_signals(), handle):
        yield


@contextlib.contextmanager
def held() -> Iterator[None]:
    """Delay signals until the end of the block; processes started in it never receive Ctrl-C."""
    if not _in_main_thread():
        yield  # Signals interrupt only the main thread.
        return
    calls: list[tuple[int, FrameType | None]] = []
    handlers = {number: signal.getsignal(number) for number in _caught_signals()}
    try:
        # Another thread can still receive the signal.
        with (
            _handled(list(handlers), lambda *call: calls.append(call)),
            kept_from_children(),
        ):
            yield
    finally:
        if calls:
            handler = handlers[signal.Signals(calls[0][0])]
            if callable(handler):
                handler(*calls[0])


@contextlib.contextmanager
def kept_from_children() -> Iterator[None]:
    """Keep Ctrl-C from the processes that this thread starts in the block."""
    # They inherit the mask.
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, _KEPT_FROM_CHILDREN)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


def _caught_signals() -> list[signal.Signals]:
    """Return the signals that Python handles: neither ignored nor left at the system's default."""
    return [number for number in SIGNALS if callable(signal.getsignal(number))]


@contextlib.contextmanager
def _handled(
    numbers: list[signal.Signals], handler: Callable[[int, FrameType | None], object]
) -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in numbers}
    try:
        for number in numbers:
            signal.signal(number, handler)
        yield
    finally:
        for number, previous in before.items():
            signal.signal(number, previous)


@contextlib.contextmanager
def _raised_again_if_lost() -> Iterator[None]:
    before = sys.unraisablehook

    def hook(lost: sys.UnraisableHookArgs) -> None:
        if issubclass(lost.exc_type, KeyboardInterrupt) and _in_main_thread():
            _raise_again()
        else:
            before(lost)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before


def _raise_again() -> None:
    """Repeat the last signal soon."""

    def repeat() -> None:
        _Received.last_s = -1.0  # No repetition of the first one.
        # A real signal also ends a wait of the main thread.
        signal.pthread_kill(threading.main_thread().ident or 0, _Received.last)

    if _Received.timer is not None:
        _Received.timer.cancel()
    _Received.timer = threading.Timer(_AGAIN_S, repeat)
    _Received.timer.start()


def _raise(number: int, _frame: FrameType | None) -> None:
    if not _accepted(number):
        return
    if _is_initialising():
        now_s = time.monotonic()
        _Received.due_s = min(_Received.due_s, now_s + _INITIALISED_S)
        if now_s < _Received.due_s:
            _raise_again()
            return
    _Received.due_s = math.inf
    raise KeyboardInterrupt


def _is_initialising() -> bool:
    """Return whether an extension module is being initialised."""
    frame: FrameType | None = sys._getframe()
    while frame is not None and frame.f_code not in _INITIALISATION:
        frame = frame.f_back
    return frame is not None


def _accepted(number: int) -> bool:
    """Note a signal, unless it repeats the last one."""
    now_s = time.monotonic()
    if now_s - _Received.last_s < _REPEAT_S and _Received.first is not None:
        return False
    _Received.last, _Received.last_s = number, now_s
    if _Received.first is None:
        _Received.first = number
    return True
