"""Our own autopilot for each test."""

import pytest

from tests.unit.mission.autopilot.own_autopilot import OwnAutopilot


@pytest.fixture
def own():
    server = OwnAutopilot()
    yield server
    server.close()
