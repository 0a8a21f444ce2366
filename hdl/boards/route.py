"""Place and route with several seeds, some of them in parallel."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from pathgene.hdl.boards.tools import BuildError, Stamp, start_tool, tool_failed


__all__ = ["MOST_JOBS", "Routed", "route"]

#: The router that terminates (router2 stalls on the full design); `closed` judges the timing.
_ROUTER = ("--router", "router1", "--timing-allow-fail")
#: Options that name a file to be read.
_INPUTS = ("--json", "--lpf", "--pcf", "--sdc")
#: Options that name a file to be written.
_OUTPUTS = ("--textcfg", "--asc", "--report")
_REPORT = "nextpnr.json"
_POLL_S = 0.2
#: Maximum seeds at a time by default, one per core: each takes some gigabytes of memory.
MOST_JOBS = 4


@dataclass(frozen=True)
class Routed:
    """A placed and routed design.

    Parameters
    ----------
    clocks : dict of str to (float, float)
        Achieved and requested frequency of each clock, MHz.
    cells : dict of str to (int, int)
        Number of cells of each kind: used, and available on the device.
    """

    seed: int
    clocks: dict[str, tuple[float, float]]
    cells: dict[str, tuple[int, int]]

    @property
    def closed(self) -> bool:
        """True if every clock is as fast as requested."""
        return self.slack >= 1

    @property
    def slack(self) -> float:
        """Achieved frequency of the worst clock as a fraction of the requested one."""
        return min(achieved / asked for achieved, asked in self.clocks.values())

    @classmethod
    def read(cls, report: Path, seed: int) -> Routed:
        """Read the result from nextpnr's ``report``."""
        content = json.loads(report.read_text(encoding="utf-8"))
        return cls(
            seed=seed,
            clocks={
                name: (clock["achieved"], clock["constraint"])
                for name, clock in content["fmax"].items()
            },
            cells={
                name: (cell["used"], cell["available"])
                for name, cell in content["utilization"].items()
            },
        )


def route(
    command: Sequence[str],
    folder: Path,
    seeds: Iterable[int],
    *,
    enough: float = 1.0,
    jobs: int | None = None,
    limit_s: float | None = None,
) -> Routed:
    """Run ``command``, a nextpnr with its arguments, with each seed until timing closes.

    Each seed has a folder ``seed-N`` in ``folder``, with links to the input files. Files of the
    returned seed are copied to ``folder``. A seed that already ran to its end with the same program
    and files is not run again.

    Parameters
    ----------
    enough : float
        Fraction of the requested frequency at which to stop.
    jobs : int, optional
        Number of seeds at a time; by default one per core, at most :data:`MOST_JOBS`.
    limit_s : float, optional
        Seconds after which a seed is stopped and counts as unroutable, because routing does not
        terminate for some seeds.

    Returns
    -------
    Routed
        The first seed, in the order of ``seeds``, that closes timing, or else the best of all. The
        result does not depend on ``jobs``, except for seeds that ``limit_s`` stops.

    Raises
    ------
    BuildError
        If every run fails.
    """
    inputs = [name for option, name in pairwise(command) if option in _INPUTS]
    jobs = jobs or min(os.cpu_count() or 1, MOST_JOBS)
    waiting = list(seeds)
    running: list[_Run] = []
    tried: list[Routed] = []
    failed: list[BuildError] = []
    close: Routed | None = None
    try:
        # The first seed in order that closes timing is returned, even if a later seed ends first.
        while running or (waiting and close is None):
            while waiting and close is None and len(running) < jobs:
                running.append(_Run(command, folder, waiting.pop(0), inputs))
                running[-1].start()
            for run in running:
                run.stop_after(limit_s)
            ended = next((run for run in running if run.has_ended()), None)
            if ended is None:
                time.sleep(_POLL_S)
                continue
            later = running[running.index(ended) + 1 :]
            running.remove(ended)
            try:
                tried.append(ended.result())
            except BuildError as error:
                # This placement cannot be routed; a different seed may be routable.
                failed.append(error)
                sys.stderr.write(f"seed {ended.seed}: {error}\n")
                continue
            _tell(tried[-1])
            if tried[-1].slack >= enough:
                close = tried[-1]
                for run in later:
                    run.stop()
                    running.remove(run)
    finally:
        for run in running:
            run.stop()
    if not tried:
        raise failed[0]
    best = close or max(tried, key=lambda routed: routed.slack)
    for file in _own(folder, best.seed).iterdir():
        if file.name not in inputs and file.suffix != Stamp.SUFFIX:
            shutil.copyfile(file, folder / file.name)
    return best


class _Run:
    """The current or an earlier run of a seed."""

    def __init__(
        self, command: Sequence[str], folder: Path, seed: int, inputs: Sequence[str]
    ) -> None:
        self.tool = command[0]
        self.folder = _own(folder, seed)
        self.seed = seed
        self.inputs = inputs
        self.arguments = [*command[1:], *_ROUTER, "--seed", str(seed), "--report", _REPORT]
        self.process: subprocess.Popen[bytes] | None = None
        self.started = 0.0
        self.stopped_after: float | None = None
        self.folder.mkdir(exist_ok=True)
        for name in inputs:
            (self.folder / name).unlink(missing_ok=True)
            os.link(folder / name, self.folder / name)
        outputs = [name for option, name in pairwise(self.arguments) if option in _OUTPUTS]
        self.stamp = Stamp(self.tool, self.arguments, self.folder, inputs, outputs)

    def start(self) -> None:
        """Start the tool unless the same run has already been done."""
        if self.stamp.matches():
            return
        for file in self.folder.iterdir():
            if file.name not in self.inputs:
                file.unlink()
        self.process = start_tool(self.tool, self.arguments, self.folder)
        self.started = time.monotonic()

    def has_ended(self) -> bool:
        return self.process is None or self.process.poll() is not None

    def result(self) -> Routed:
        """Return the result once the run has ended."""
        if self.stopped_after is not None:
            raise BuildError(f"{self.tool} did not terminate within {self.stopped_after:,.0f} s.")
        if self.process is not None:
            if status := self.process.returncode:
                raise tool_failed(self.tool, self.folder, status)
            self.stamp.set()
        return Routed.read(self.folder / _REPORT, self.seed)

    def stop_after(self, limit_s: float | None) -> None:
        """Stop the tool if it has run for longer than ``limit_s``."""
        late = limit_s is not None and time.monotonic() - self.started > limit_s
        if late and not self.has_ended():
            self.stop()
            self.stopped_after = limit_s

    def stop(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.wait()


def _own(folder: Path, seed: int) -> Path:
    return folder / f"seed-{seed}"


def _tell(routed: Routed) -> None:
    clocks = ", ".join(
        f"{name} {achieved:.1f} of {asked:.1f} MHz"
        for name, (achieved, asked) in routed.clocks.items()
    )
    sys.stderr.write(f"seed {routed.seed}: {clocks}\n")
