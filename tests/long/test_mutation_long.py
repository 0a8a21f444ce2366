"""Mutation testing of the whole gateware, which takes hours."""

import pytest

from tools.mutate import main


pytestmark = pytest.mark.long


def test_nearly_all_alterations_are_killed():
    """CONTRIBUTING.md gives the reason of each survivor."""
    assert main(["--seed", "2026", "--count", "200", "--jobs", "2", "--require", "95"]) == 0
