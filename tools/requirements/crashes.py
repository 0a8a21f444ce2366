"""Pytest plugin that reports a test as an error, not as failed, unless an assertion failed.

Load it with ``-p tools.requirements.crashes``. A crash, such as a ``NameError``, shows that a fault
breaks something; only a failed assertion shows which promise it breaks. ``pytest.fail`` and a
missing exception in ``pytest.raises`` count as assertions.
"""

from __future__ import annotations

from collections.abc import Generator

import pytest


_ASSERTIONS = (AssertionError, pytest.fail.Exception)
_CRASHED = "crashed"


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Mark the report of a test that fails by another exception."""
    report = yield
    raised = None if call.excinfo is None else call.excinfo.value
    setattr(report, _CRASHED, report.failed and not _is_assertion(raised))
    return report


@pytest.hookimpl(tryfirst=True)
def pytest_report_teststatus(report: pytest.TestReport) -> tuple[str, str, str] | None:
    """Report a marked test as an error."""
    return ("error", "E", "ERROR") if getattr(report, _CRASHED, False) else None


def _is_assertion(error: BaseException | None) -> bool:
    if isinstance(error, BaseExceptionGroup):
        return any(map(_is_assertion, error.exceptions))
    return isinstance(error, _ASSERTIONS)
