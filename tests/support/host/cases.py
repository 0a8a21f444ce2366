"""Files from public reports that were misread, if they are next to the project."""

from pathlib import Path

import pytest


CASES = Path(__file__).resolve().parents[4] / "shared" / "cases"


def case(name):
    """Return a file by its folder and name; skip the test where it is absent."""
    file = CASES / name
    if not file.exists():
        pytest.skip(f"the file {name} is not next to the project")
    return file
