"""Pytest plugin that limits the processor time of each test, to end a hanging simulation.

Load it with ``-p tools.mutation.limit``; ``MUTATION_LIMIT`` is the limit in seconds. Only the
test's own processor time counts, so no test fails because the machine is busy.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from types import FrameType

import pytest


def _expire(number: int, frame: FrameType | None) -> None:
    pytest.fail("limit of processor time reached", pytrace=False)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol() -> Iterator[None]:
    """Run one test with a timer."""
    signal.signal(signal.SIGPROF, _expire)
    signal.setitimer(signal.ITIMER_PROF, float(os.environ.get("MUTATION_LIMIT", "60")))
    try:
        return (yield)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
