"""Processes that a test starts: they end with it, and their times allow for a busy machine."""

import contextlib
import os
import resource
import signal
import subprocess
import sys
import threading
import time


__all__ = ["Started", "slowdown"]

# Wait for a process at the end of its block.
_LIMIT_S = 120.0


class Started(subprocess.Popen):
    """A process that ends with its block: killed after a failure, or if it runs on for minutes.

    ``subprocess.Popen`` waits instead, after a failed assertion for ever. If the process has a
    session of its own, so do its children, which are killed too.
    """

    def __init__(self, *arguments, start_new_session=False, **options):
        self._leads = start_new_session
        super().__init__(*arguments, start_new_session=start_new_session, **options)

    def __exit__(self, kind, error, traceback):
        """Wait for the process, and close its pipes."""
        late = threading.Timer(_LIMIT_S, self._end)
        late.start()
        try:
            if kind is not None:
                self._end()
            super().__exit__(kind, error, traceback)
        finally:
            late.cancel()

    def _end(self):
        with contextlib.suppress(ProcessLookupError):
            if self._leads:
                os.killpg(self.pid, signal.SIGKILL)
        self.kill()


def slowdown():
    """Return how much longer than its processor time a small process takes now, 1 or more."""
    before, begun_s = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    subprocess.run([sys.executable, "-c", "import json, argparse"], check=True)
    took_s, after = time.monotonic() - begun_s, resource.getrusage(resource.RUSAGE_CHILDREN)
    used_s = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return max(1.0, took_s / used_s)
