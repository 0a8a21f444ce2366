"""The mission that an autopilot gets, on the page of the desk."""

import asyncio
import time

import pytest

from pathgene.host.web.desk.desk import Desk
from tests.unit.web.desk.test_page import opened


@pytest.mark.ci
def test_a_found_and_a_loaded_plan_show_the_same_mission(tmp_path):
    desk = Desk(tmp_path)
    sheet = desk._first
    sheet.take_terrain("jacksboro")
    for end, place in (("start", (8000, 8000)), ("goal", (14000, 16000))):
        sheet.place(end, *place)
    sheet.set("planner", "astar")
    job = desk.plan(desk.sheet())
    deadline = time.monotonic() + 120
    while not job.done:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    mission = job.path["mission"]
    assert len(mission["circles"]) == 1
    assert len(mission["items"]) > 3

    async def use():
        async with opened(desk, "astar") as (_, page):
            assert await page._load(job.folder.name)
            assert page._results.plan.path["mission"] == mission

    asyncio.run(use())
    desk.close()
