"""The command ``pathgene``, also as ``python -m pathgene``."""

from __future__ import annotations

import atexit
import contextlib
import gc
import os
import signal
import sys
import threading
from typing import NoReturn


__all__ = ["main", "program"]

# New objects after which Python looks for garbage, instead of 700.
_OBJECTS = 300_000


def main() -> int:
    """Run the command line; Ctrl-C while the program is imported ends it without a traceback."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    # A command multiplies only small matrices, and starting a thread on each core takes longer.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Where the package `coverage` is installed, numba imports it, which no command needs.
    # None makes its import fail; the type of the dictionary does not have it.
    sys.modules.setdefault("coverage", None)  # type: ignore[arg-type]
    # Imports make hundreds of thousands of objects that live until the end; looking for garbage
    # among them again and again takes up to a tenth of a command's time.
    gc.set_threshold(_OBJECTS)
    try:
        from pathgene.host.cli import main as run

        return run()
    finally:
        # The end of the process looks through all objects that are not frozen.
        gc.freeze()


def program() -> NoReturn:
    """Run the command line and end the process with its status.

    The system takes back the memory of a process at once, while Python would free each object
    and module by itself, which takes as long as importing numpy.
    """
    status = main()
    # Python waits for other threads.
    if threading.active_count() == 1:
        atexit._run_exitfuncs()
        # An output that cannot be written is Python's to report.
        with contextlib.suppress(OSError, ValueError):
            for stream in (sys.stdout, sys.stderr):
                if stream is not None:
                    stream.flush()
            os._exit(status)
    sys.exit(status)


if __name__ == "__main__":
    program()
