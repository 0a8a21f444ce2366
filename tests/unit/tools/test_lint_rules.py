"""The rules of ``make lint`` that need no Verilog: ruff, its format, and the types."""

import subprocess
import sys
from pathlib import Path

import pytest


pytestmark = pytest.mark.ci

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.parametrize(
    "command",
    [("ruff", "check", "."), ("ruff", "format", "--check", "."), ("mypy",)],
    ids=["rules", "format", "types"],
)
def test_sources_are_clean(command):
    done = subprocess.run(
        [sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
