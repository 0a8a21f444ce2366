"""A mission of another ground station in Chromium: dropped, judged, mended and downloaded."""

import base64

import pytest

from pathgene.host.formats.registry import read_mission
from pathgene.host.mission.foreign.check import check_mission
from pathgene.host.mission.foreign.judge import FlightProblem
from pathgene.host.problem.zones import read_zones
from pathgene.host.terrain import load
from tests.browser.desk_page import ready
from tests.support.host.foreign import NOWHERE, write_planted


pytestmark = pytest.mark.ci


def drop(page, file):
    """Drop a file on the page as a user does."""
    page.evaluate(
        """([name, content]) => {
          const bytes = Uint8Array.from(atob(content), (letter) => letter.charCodeAt(0));
          const dataTransfer = new DataTransfer();
          dataTransfer.items.add(new File([bytes], name));
          const options = { dataTransfer, bubbles: true, cancelable: true };
          document.querySelector("main, body").dispatchEvent(new DragEvent("drop", options));
        }""",
        [file.name, base64.b64encode(file.read_bytes()).decode()],
    )


def test_a_dropped_mission_is_seen_mended_and_taken_along(open_desk, tmp_path):
    plan, ground = write_planted(tmp_path, "fence", faulty=True)
    page = open_desk()
    # Off the map.
    drop(page, plan)
    page.get_by_text("m.plan cannot be opened as a mission: the mission lies outside").wait_for()
    drop(page, ground)
    page.wait_for_function("() => document.querySelector('.stage').dataset.ready !== 'jacksboro'")
    ready(page)
    drop(page, plan)
    fault = page.locator(".faults button")
    fault.wait_for()
    # From the last to the first, so that the numbers stay.
    for close in reversed(page.get_by_role("button", name="Close", exact=True).all()):
        close.click()
    assert "zone 1 entered by" in fault.text_content()
    shown = page.evaluate(
        """() => {
          const { map, profile } = window.pathgene;
          return [map.faults.length, profile.scene.faults.length, profile.track.broken.length];
        }"""
    )
    assert shown == [1, 1, 1]
    fault.click()
    # The desk answers the click over the network.
    page.wait_for_function("() => pathgene.profile.s !== null")
    at_m, s = page.evaluate("() => [pathgene.map.faults[0].at_m, pathgene.profile.s]")
    assert s == pytest.approx(at_m)
    page.get_by_role("button", name="Mend", exact=True).click()
    page.get_by_role("button", name="Show as opened").wait_for()
    page.wait_for_function("() => pathgene.map.faults.length === 0 && pathgene.profile.beside")
    # Both tracks are drawn, the one that was opened in the colour of a kept plan.
    colours = page.evaluate("() => pathgene.map.paths.map(({ colour }) => colour)")
    assert {"path", "#d55e00"} <= set(colours)
    with page.expect_download() as download:
        page.get_by_role("button", name="Download m-mended.plan").click()
    mended = tmp_path / download.value.suggested_filename
    download.value.save_as(mended)
    terrain = load(ground)
    zones = read_zones(mended, terrain).zones
    problem = FlightProblem(terrain, NOWHERE, NOWHERE, zones=zones)
    assert check_mission(read_mission(mended), problem).feasible
    assert not check_mission(read_mission(plan), problem).feasible
    page.get_by_role("button", name="Close mission").click()
    page.wait_for_function("() => !pathgene.profile.track && pathgene.map.points.length === 2")
