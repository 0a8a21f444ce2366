"""Runs bad inputs in separate processes with limits, and reports each outcome.

``python -m tests.support.bad_input.runs SEED FIRST LAST`` prints the number of each case that
violates the rule, with the reason, then the number of surely bad cases and, for each kind, the
numbers of refused and accepted cases. One process imports the whole program and forks for each
case, which takes a hundredth of a second instead of one.
"""

import contextlib
import io
import json
import os
import re
import resource
import shutil
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from pathgene.host.cli import main
from pathgene.host.cli.output import LONGEST_LINE
from tests.support.bad_input.good_inputs import write_base
from tests.support.bad_input.inputs import cases
from tests.support.bad_input.options import CHECK, Case


MOST_BYTES = 2 * 10**9
# Seconds of the processor, which other programs do not lengthen.
MOST_S = 20.0
# Beginnings of the report on files that were read.
REPORTED = tuple(f"pathgene: {each}" for each in ("Terrain ", "Mission ", "Note: ", "Warning: "))
# Seconds of the clock after which a case that waits for nothing is killed.
_DEADLINE_S = 15 * MOST_S


@dataclass(frozen=True)
class End:
    """The end of a case.

    Parameters
    ----------
    status : int
        Exit status, or the negative number of the signal that ended it.
    error : str
        Its text on standard error.
    seconds, bytes : float, int
        Time of the processor, and peak memory.
    """

    status: int
    error: str
    seconds: float
    bytes: int


def run(case: Case, folder: Path) -> End:
    """Run a case in an empty folder next to the good files, in a forked process."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for name, content in case.files.items():
        (folder / name).write_bytes(content)
    output, error = folder.with_name("stdout"), folder.with_name("stderr")
    child = os.fork()
    if not child:
        _run_here(case, folder, output, error)
    status, usage = _waited(child)
    return End(
        os.waitstatus_to_exitcode(status),
        error.read_text("utf-8", "backslashreplace"),
        usage.ru_utime + usage.ru_stime,
        1024 * usage.ru_maxrss,
    )


def _run_here(case: Case, folder: Path, output: Path, error: Path) -> None:
    """Run a case in this process, then end the process."""
    status = 99
    with contextlib.suppress(BaseException):
        os.chdir(folder)
        for number, path, mode in (
            (0, Path(os.devnull), os.O_RDONLY),
            (1, output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC),
            (2, error, os.O_WRONLY | os.O_CREAT | os.O_TRUNC),
        ):
            os.dup2(os.open(path, mode, 0o600), number)
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + MOST_BYTES, used + MOST_BYTES))
        status = main(list(case.arguments))
    sys.stderr.flush()
    os._exit(status)


def _waited(child: int) -> tuple[int, resource.struct_rusage]:
    deadline_s = time.monotonic() + _DEADLINE_S
    while True:
        number, status, usage = os.wait4(child, os.WNOHANG)
        if number:
            return status, usage
        if time.monotonic() > deadline_s:
            os.kill(child, 9)
            _, status, usage = os.wait4(child, 0)
            return status, usage
        time.sleep(0.002)


def fault(case: Case, end: End) -> str | None:
    """Return the fault of a case's end, or None."""
    # A note on an option without meaning for the planner precedes every other sentence.
    lines = [line for line in end.error.splitlines() if not line.endswith(" and is ignored.")]
    # So does the report on files that were read before the refusal.
    lines = [line for line in lines[:-1] if not line.startswith(REPORTED)] + lines[-1:]
    if end.status not in (0, 1, 2):
        return f"status {end.status}"
    if case.surely_bad and not is_refused(end):
        return f"status {end.status} of what is surely bad"
    if any(word in end.error for word in ("Internal error", "Traceback", "internal error")):
        return "an internal error"
    if case.arguments[0] == "batch":
        lines = [line for line in lines if not line.startswith("problem ")]
        named = [line.split(":")[1] for line in lines if re.match(r"pathgene: [^ :]+: ", line)]
        # A batch has one sentence for each faulty problem.
        if len(lines) > 1 and not len(lines) == len(named) == len(set(named)):
            return f"{len(lines)} lines of a batch"
    elif end.status == 2 and len(lines) != 1:
        return f"{len(lines)} lines"
    if end.status and not (lines and lines[-1].startswith("pathgene: ")):
        return "no sentence"
    if end.status == 2 and not lines[-1].endswith((".", "?")):
        return "no end of a sentence"
    if (longest := max(map(len, lines), default=0)) > LONGEST_LINE:
        return f"a line of {longest} characters"
    if end.bytes > MOST_BYTES or end.seconds > MOST_S:
        return f"{end.bytes / 1e6:.0f} MB, {end.seconds:.1f} s"
    return None


def is_refused(end: End) -> bool:
    """Return whether a case ended as bad input, and not because its folder could not be created."""
    return end.status == 2 and not re.search("Cannot write to .*path.csv", end.error)


def tell(seed: int, first: int, last: int) -> None:
    """Run cases ``first`` up to but not including ``last``; print faults as lines of JSON."""
    refused: Counter[str] = Counter()
    accepted: Counter[str] = Counter()
    surely_bad = 0
    with tempfile.TemporaryDirectory() as made:
        base = Path(made, "base")
        base.mkdir()
        write_base(base)
        # Loads the modules and compiled kernels of a valid case.
        (base.parent / "warm").mkdir()
        run_in = Path.cwd()
        os.chdir(base.parent / "warm")
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            main(list(CHECK))
        os.chdir(run_in)
        for index, case in islice(enumerate(cases(seed, last)), first, None):
            end = run(case, base.parent / "case")
            kind = case.kind.split(",")[0]
            surely_bad += case.surely_bad
            (refused if is_refused(end) else accepted)[kind] += 1
            wrong = fault(case, end)
            if wrong is not None:
                arguments = [argument[:200] for argument in case.arguments]
                said = end.error[-2000:]
                print(json.dumps([index, case.kind, wrong, arguments, said]), flush=True)
    counts = [dict(sorted(count.items())) for count in (refused, accepted)]
    print(json.dumps([surely_bad, *counts]), flush=True)


if __name__ == "__main__":
    tell(*map(int, sys.argv[1:]))
