"""The simulated board as a process that ends with the process that started it."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import time
import weakref
from pathlib import Path
from typing import Self

from pathgene.host.device.socket_port import SocketPort
from pathgene.host.errors import JobError
from pathgene.sim.board.programs import Program


__all__ = ["SimulatedBoard"]


class SimulatedBoard:
    """A running simulator, reached over TCP or a pseudo terminal.

    The simulator ends at :meth:`close`, at the end of the ``with`` block, when the object is
    collected, at interpreter exit, and whenever this process ends: it watches its parent and its
    standard input. Ctrl-C does not reach the simulator, so that the host can still talk to the
    board while the host finishes.

    Parameters
    ----------
    listen : str
        ``HOST:PORT`` to listen on; port 0 chooses a free port.
    pty : bool
        Serve a pseudo terminal instead of TCP.
    keep : bool
        Wait for another client when one leaves, and give the board to a waiting client when no byte
        passes for a second; otherwise the simulator ends with its only client.
    idle_clocks : int, optional
        Cycles simulated at full speed after the last activity; default 2**20.
    trace : Path, optional
        VCD file to write.
    timeout_s : float
        Maximum wait in seconds for the simulator to start or to report its cycles.

    Raises
    ------
    JobError
        If the simulator does not start.
    """

    def __init__(
        self,
        program: Program,
        *,
        listen: str = "127.0.0.1:0",
        pty: bool = False,
        keep: bool = False,
        idle_clocks: int | None = None,
        trace: Path | None = None,
        timeout_s: float = 30.0,
    ) -> None:
        self.program = program
        self.timeout_s = timeout_s
        self._keep = keep
        command = program.command(
            listen=listen, pty=pty, keep=keep, idle_clocks=idle_clocks, trace=trace
        )
        self._log = os.memfd_create("simulator")
        weakref.finalize(self, os.close, self._log)
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._log,
                bufsize=0,
                start_new_session=True,
            )
        except OSError as error:
            raise JobError(
                f"The simulator {command[0]} does not start: {error.strerror}."
            ) from None
        self._finalizer = weakref.finalize(self, _end, self._process)
        self._pending = b""
        kind, _, where = self._answer("port ", "pty ").partition(" ")
        host = listen.rpartition(":")[0] or "127.0.0.1"
        #: Address of the board: ``socket://HOST:PORT``, or the path of a terminal.
        self.url = where if kind == "pty" else f"socket://{host}:{where}"
        self._address = None if kind == "pty" else (host, int(where))

    def open(self, *, timeout: float | None = 1.0, ends_board: bool = False) -> SocketPort:
        """Connect to the board, which serves one client at a time.

        Parameters
        ----------
        timeout : float or None
            Timeout of the port's reads, seconds.
        ends_board : bool
            Closing the port also ends the board.

        Raises
        ------
        JobError
            If the simulator has ended, does not accept clients, or serves a pseudo terminal.
        """
        self.check()
        if self._address is None:
            raise JobError(f"The simulated board serves a terminal; open {self.url} instead.")
        try:
            return SocketPort(
                self._address,
                timeout=timeout,
                explain=self._explain,
                on_close=self.close if ends_board else None,
            )
        except OSError as error:
            raise JobError(f"No board answers at {self.url}: {error}.") from None

    @property
    def pid(self) -> int:
        """Process id of the simulator."""
        return self._process.pid

    def cycles(self) -> int:
        """Return the number of simulated cycles.

        Raises
        ------
        JobError
            If the simulator has ended, or does not answer within ``timeout_s``.
        """
        self._order("")
        return int(self._answer("cycles ").split()[1])

    def check(self) -> None:
        """Raise an error with the reason if the simulator has ended.

        Raises
        ------
        JobError
            If the simulator is not running.
        """
        if self._process.poll() is not None:
            raise JobError(self._explain())

    def wait(self, timeout_s: float | None = None) -> int | None:
        """Wait for the end of the simulator.

        Parameters
        ----------
        timeout_s : float, optional
            Longest wait, seconds; None waits without limit.

        Returns
        -------
        int or None
            Exit status, negative for a signal; None if the simulator still runs.
        """
        try:
            return self._process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            return None

    def log(self) -> str:
        """Return the simulator's standard error: line errors and a summary."""
        # pread does not change the file position, which is shared with the simulator's writes.
        return os.pread(self._log, os.fstat(self._log).st_size, 0).decode(errors="replace")

    def close(self) -> None:
        """End the simulator and wait for its end. A second call does nothing."""
        self._finalizer()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _order(self, line: str) -> None:
        """Write a line to the simulator's standard input; ``bridge.hpp`` describes the orders."""
        self.check()
        with contextlib.suppress(BrokenPipeError):
            assert self._process.stdin is not None
            self._process.stdin.write(f"{line}\n".encode())

    def _answer(self, *prefixes: str) -> str:
        """Return the next line of the simulator's standard output that starts with a prefix."""
        deadline = time.monotonic() + self.timeout_s
        assert self._process.stdout is not None
        while True:
            line, newline, rest = self._pending.partition(b"\n")
            if newline:
                self._pending = rest
                text = line.decode(errors="replace")
                if text.startswith(prefixes):
                    return text
                continue
            left = deadline - time.monotonic()
            if left <= 0 or not select.select([self._process.stdout], [], [], left)[0]:
                self.close()
                raise JobError(
                    f"The simulated board did not answer for {self.timeout_s:g} s and was ended."
                )
            part = self._process.stdout.read(4096)
            if not part:
                self.wait(self.timeout_s)
                raise JobError(self._explain())
            self._pending += part

    def _explain(self) -> str:
        status = self.wait(1.0)
        if status is None and self._keep:
            return "The simulated board was taken by another client after a second without bytes."
        if status is None:
            return "The simulated board closed the connection; start it with keep set to go on."
        lines = self.log().strip().splitlines()
        last = lines[-1].removeprefix("simulator: ") if lines else "it printed nothing"
        return f"The simulated board ended with {_describe(status)}: {last}."


def _describe(status: int) -> str:
    if status >= 0:
        return f"status {status}"
    try:
        return f"signal {signal.Signals(-status).name}"
    except ValueError:
        return f"signal {-status}"


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a simulator and the processes that it started, with SIGTERM, then SIGKILL."""
    if process.poll() is None:
        process.terminate()
        process.send_signal(signal.SIGCONT)  # A stopped process does not handle signals.
        try:
            process.wait(2.0)
        except subprocess.TimeoutExpired:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            pipe.close()
