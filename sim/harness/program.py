"""A Verilated design with a C++ harness: a process that takes orders and answers in numbers."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import JobError
from pathgene.sim.cache import BuildCache, build_root
from pathgene.sim.verilator import build_verilator


__all__ = ["VerilatedProgram"]

_SIM = Path(__file__).resolve().parents[1]


class VerilatedProgram:
    """A design that Verilator simulates in another process.

    Numbers are 64-bit little-endian in both directions; ``harness.hpp`` has the C++ for them.

    Parameters
    ----------
    verilog : str
        Text of the design.
    top : str
        Its top module.
    main : Path
        C++ file with ``main``.
    arguments : sequence of str
        Arguments of the program.
    builds : BuildCache, optional
        Keeps the program; by default the cache of all simulations.
    options
        Further arguments of :func:`pathgene.sim.verilator.build_verilator`.

    Raises
    ------
    JobError
        If a tool is missing; from every method, if the simulation ends before its answer.
    """

    def __init__(
        self,
        verilog: str,
        top: str,
        main: Path,
        *arguments: str,
        builds: BuildCache | None = None,
        **options: Any,
    ) -> None:
        headers = [_SIM / "harness" / "harness.hpp", _SIM / "board" / "uart.hpp"]
        builds = builds or BuildCache(build_root() / "sim")
        program = build_verilator(builds, verilog, top, main=main, headers=headers, **options)
        self._process = subprocess.Popen(
            [str(program), *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """End the process."""
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()
        self._process.terminate()
        self._process.wait()

    def send(self, *parts: int | bytes | Sequence[int] | NDArray[np.uint64]) -> None:
        """Send an order: numbers, arrays of numbers, and bytes."""
        data = [
            part if isinstance(part, bytes) else np.asarray(part, dtype="<u8").tobytes()
            for part in parts
        ]
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(b"".join(data))
            self._process.stdin.flush()
        except OSError:
            raise self._ended() from None

    def receive(self, numbers: int) -> NDArray[np.uint64]:
        """Wait for this many numbers."""
        return np.frombuffer(self.receive_bytes(8 * numbers), dtype="<u8").astype(np.uint64)

    def receive_bytes(self, size: int) -> bytes:
        """Wait for this many bytes."""
        assert self._process.stdout is not None
        data = self._process.stdout.read(size)
        if len(data) != size:
            raise self._ended()
        return data

    def _ended(self) -> JobError:
        return JobError("The simulated design ended; see what it printed.")
