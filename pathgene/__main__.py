"""The command ``pathgene``, also as ``python -m pathgene``."""

from __future__ import annotations

import os
import signal
import sys


__all__ = ["main"]


def main() -> int:
    """Run the command line; Ctrl-C while the program is imported ends it without a traceback."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    # A command multiplies only small matrices, and starting a thread on each core takes longer.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from pathgene.host.cli import main as run

    return run()


if __name__ == "__main__":
    sys.exit(main())
