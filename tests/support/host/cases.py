"""Files next to the project: public reports that were misread, and flights of real autopilots."""

from pathlib import Path

import pytest


_SHARED = Path(__file__).resolve().parents[4] / "shared"
CASES = _SHARED / "cases"
FLIGHTS = _SHARED / "flights"


def case(name):
    """Return a file by its folder and name; skip the test where it is absent."""
    file = CASES / name
    if not file.exists():
        pytest.skip(f"the file {name} is not next to the project")
    return file


def flight_folder(name):
    """Return the folder of a real flight; skip the test where it is absent."""
    folder = FLIGHTS / name
    if not folder.exists():
        pytest.skip(f"the flight {name} is not next to the project")
    return folder
