"""First compilation of kernels, in a process of its own.

A compilation in the process of a command would delay its signals by up to a minute, since it cannot
be interrupted. The helper, ``python -m pathgene.host.compiling PARENT``, compiles the kernels that
a command misses and leaves them in numba's cache. A request is the name of a function and its
arguments, pickled; the reply is a byte per compiled kernel, and another at the end.
"""

from __future__ import annotations

import contextlib
import importlib
import operator
import os
import pickle
import select
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba.core import event

from pathgene.host import interrupts
from pathgene.jit import COMPILING, compile_by


__all__ = ["compile_apart", "compile_evaluation", "compile_first", "end"]

# Period at which the helper looks for its parent, and a thread for a signal.
_LOOK_S = 0.2
# A thread waits after a signal for as long as a search that does not respond.
_GRACE_S = 1.0
# The bytes of a reply.
_KERNEL, _END = b"+", b"."


def compile_apart() -> None:
    """Let a helper compile the kernels that this process misses, until :func:`end`.

    A signal ends the helper and the wait for it. If the helper fails, the kernel is compiled here.
    """
    compile_by(lambda module, name, types: _HELPER.call(module, f"{name}.compile", types))


def compile_first(*, as_paper: bool, progress: Callable[[int], None]) -> None:
    """Let the helper compile the kernels of the evaluation, and wait for it.

    Parameters
    ----------
    progress : callable
        Called after each kernel with the number of kernels compiled.
    """
    request = "pathgene.host.compiling", "compile_evaluation", as_paper
    _HELPER.call(*request, progress=progress)


def end() -> None:
    """End the helper, if it runs, and compile the kernels here from now on."""
    compile_by(None)
    _HELPER.end()


def compile_evaluation(as_paper: bool) -> None:
    """Evaluate two small problems, one with zones and one without, as a search and a report do."""
    import numpy as np

    from pathgene.host.evaluation import Evaluator
    from pathgene.host.problem.problem import Problem
    from pathgene.host.problem.zones import Zone
    from pathgene.host.terrain import Terrain

    terrain = Terrain("flat", np.full((30, 30), 100.0), 100.0, 100.0)
    ends = (500.0, 500.0, 250.0), (2500.0, 2500.0, 250.0)
    corners = [(100.0, 2000.0), (400.0, 2000.0), (100.0, 2500.0)]
    for zones in ((), (Zone.circle(2000, 800, 100), Zone.polygon(corners))):
        problem = Problem(terrain, *ends, zones=zones, as_paper=as_paper)
        evaluator = Evaluator(problem)
        path = np.array([ends[0], (1500.0, 1400.0, 260.0), ends[1]])
        paths, lengths = np.repeat(path[None], 4, axis=0), np.full(4, len(path), dtype=np.int64)
        evaluator.evaluate(path)
        evaluator.fitness(paths, lengths)
        for fine in (False, True):
            evaluator.penalty_cost(paths, lengths, fine=fine)
        if not as_paper:
            evaluator.fitness(paths, lengths, strict=True)
            evaluator.lowest_at_m(path)
            # Through a zone, and low.
            evaluator.broken(np.array([ends[0], (2000.0, 800.0, 50.0), ends[1]]))


class _Helper:
    """The helper, which starts with its first request."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()

    def call(
        self,
        module: str,
        name: str,
        *arguments: Any,
        progress: Callable[[int], None] = lambda _: None,
    ) -> None:
        """Call a function there, and wait for its end; an error there has no effect here."""
        try:
            request = pickle.dumps((module, name, arguments))
        except Exception:  # Which error pickle raises depends on the type.
            return
        with self._lock:
            try:
                if not self._replied(request, progress):
                    self.end()
            except BaseException:
                self.end()
                raise

    def end(self) -> None:
        """Kill the process, if there is one."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            with process:  # Closes its pipes.
                process.wait()

    def _replied(self, request: bytes, progress: Callable[[int], None]) -> bool:
        """Send a request, and return whether a reply came to its end."""
        if self._process is None:
            self._process = _started()
        requests, replies = self._process.stdin, self._process.stdout
        assert requests is not None
        assert replies is not None
        try:
            requests.write(request)
        except OSError:
            return False
        done = 0
        while True:
            if threading.current_thread() is not threading.main_thread():
                _wait_in_thread(replies.fileno())
            if (reply := replies.read(1)) != _KERNEL:
                return reply == _END
            done += 1
            progress(done)


_HELPER = _Helper()


def _started() -> subprocess.Popen[bytes]:
    folder = str(Path(__file__).absolute().parents[2])
    path = os.pathsep.join(filter(None, (folder, os.environ.get("PYTHONPATH"))))
    return subprocess.Popen(
        [sys.executable, "-m", "pathgene.host.compiling", str(os.getpid())],
        env={**os.environ, "PYTHONPATH": path},
        bufsize=0,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def _wait_in_thread(replies: int) -> None:
    """Wait until there is a reply; a signal, which interrupts only the main thread, ends it."""
    signalled_s = None
    while not select.select([replies], [], [], _LOOK_S)[0]:
        if signalled_s is None and interrupts.status(default=0):
            signalled_s = time.monotonic()
        if signalled_s is not None and time.monotonic() > signalled_s + _GRACE_S:
            raise KeyboardInterrupt


def _end_with(parent: int) -> None:
    """End this process when its parent has ended without ending it."""
    while os.getppid() == parent:
        time.sleep(_LOOK_S)
    os._exit(1)


class _Told(event.Listener):  # type: ignore[misc]  # numba has no types.
    """Tells the parent of each kernel compiled."""

    def __init__(self, replies: int) -> None:
        self._replies = replies

    def on_start(self, event: Any) -> None:
        """Do nothing."""

    def on_end(self, event: Any) -> None:
        """Tell the parent."""
        os.write(self._replies, _KERNEL)


def _serve() -> None:
    """Call functions until the parent closes the requests."""
    replies = os.dup(1)
    os.dup2(2, 1)  # Nothing else is a reply.
    event.register(COMPILING, _Told(replies))
    while True:
        module, name, arguments = pickle.load(sys.stdin.buffer)
        with contextlib.suppress(Exception):  # The parent meets the error again, and reports it.
            operator.attrgetter(name)(importlib.import_module(module))(*arguments)
        os.write(replies, _END)


if __name__ == "__main__":
    threading.Thread(target=_end_with, args=(int(sys.argv[1]),), daemon=True).start()
    with contextlib.suppress(EOFError):
        _serve()
