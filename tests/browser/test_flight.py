"""A flight on the page of the desk: zones are drawn in its way, and it is replanned."""

import re
import time

import pytest

from pathgene.host.inputs import parse_json
from tests.browser.desk_page import PATIENCE_MS, canyon, choose, panel, plan, ready, spot
from tests.browser.seen import colours, pixels, settle


pytestmark = pytest.mark.ci


def aircraft(page):
    """Position of the aircraft on the map."""
    return page.evaluate("window.pathgene.map.aircraft")


def flying(page):
    return page.locator('[data-role="flying"]').text_content()


def latest(page):
    return page.locator('[data-role="replan"]').text_content()


def until(page, condition):
    deadline = time.monotonic() + PATIENCE_MS / 1000
    while not condition():
        assert time.monotonic() < deadline, (flying(page), latest(page))
        page.wait_for_timeout(50)


def take_off(page):
    """Plan over the canyon and fly; return the folder of the plan."""
    canyon(page)
    choose(page, "planner", "ga-chip")
    folder = plan(page)
    page.get_by_role("button", name="Fly", exact=True).click()
    until(page, lambda: aircraft(page) is not None)
    # A page that is drawn in software answers in seconds, which are a minute of a faster flight.
    choose(page, "speed", "1 ×")
    return folder


def test_zones_drawn_in_flight_are_flown_around(open_desk):
    page = open_desk()
    folder = take_off(page)
    first = aircraft(page)
    until(page, lambda: aircraft(page)["y"] > first["y"] + 30)
    # A zone on the path, with the keyboard.
    page.get_by_role("button", name="Zone ahead").press("Enter")
    until(page, lambda: latest(page))
    found = re.fullmatch(
        r"New path after ([\d.]+) ms and ([\d.]+) m \(chip and line [\d.]+; "
        r"assumed: round trips \d+, host \d+\)",
        latest(page),
    )
    assert 5 < float(found[1]) < 100
    assert float(found[2]) < 3
    page.wait_for_function("() => window.pathgene.map.zones[0]?.name === 'pop-up 1'")
    assert page.locator('[data-role="flying"]').bounding_box()["height"] > 10
    # Another with the mouse, on the goal; then it is removed.
    page.get_by_role("button", name="Circle", exact=True).click()
    goal = page.evaluate("window.pathgene.map.points[1]")
    sides = page.evaluate(
        "[map.terrain.width_m, map.terrain.height_m]".replace("map", "pathgene.map")
    )
    x, y = goal["x"] / sides[0], goal["y"] / sides[1]
    page.mouse.move(*spot(page, x, y))
    page.mouse.down()
    page.mouse.move(*spot(page, x + 0.03, y), steps=4)
    page.mouse.up()
    log = page.locator(".log")
    until(page, lambda: "a zone appears" in log.text_content())
    until(page, lambda: len(page.evaluate("window.pathgene.map.zones")) == 2)
    page.get_by_role("button", name="Zones away").click()
    until(page, lambda: not page.evaluate("window.pathgene.map.zones"))
    settle(page)
    for part in ("relief", "plan"):
        assert colours(pixels(page.locator(f'[data-part="{part}"] canvas'))) > 100, part
    drawn = page.evaluate(
        "window.pathgene.map.paths.map(({ colour, opacity }) => [colour, opacity])"
    )
    assert drawn[0] == ["path", 0.35]
    assert drawn[-1] == ["#d55e00", 1]
    choose(page, "speed", "64 ×")
    until(page, lambda: "Arrived" in flying(page) and "saving" not in flying(page))
    assert "everything kept" in flying(page)
    flight = parse_json((folder / "flight.json").read_text())
    assert flight["kept"]
    assert flight["planner"] == "ga-chip"
    assert len(flight["changes"]) >= 3
    page.get_by_role("button", name="Close flight").click()
    page.wait_for_function("() => window.pathgene.map.aircraft === null")
    with page.expect_download() as download:
        page.get_by_role("link", name="Flight, moving").click()
    assert download.value.suggested_filename == "flight.gif"


@pytest.mark.long  # Drawing a flight in software takes minutes.
def test_the_goal_is_another_in_flight_and_a_flight_ends_without_files(open_desk):
    page = open_desk()
    folder = take_off(page)
    page.get_by_role("button", name="Goal", exact=True).click()
    page.mouse.click(*spot(page, 0.3, 0.8))
    until(page, lambda: latest(page))
    page.wait_for_function(
        "() => Math.abs(pathgene.map.points[1].x / pathgene.map.terrain.width_m - 0.3) < 0.01"
    )
    # The same with the keyboard.
    for name, value in (("New goal, east m", 1000), ("New goal, north m", 4200)):
        page.get_by_label(name).fill(str(value))
    page.get_by_role("button", name="New goal").press("Enter")
    page.wait_for_function("() => pathgene.map.points[1].x === 1000")
    goal = page.evaluate("window.pathgene.map.points[1]")
    page.get_by_role("button", name="End flight").click()
    until(page, lambda: "not saved" in flying(page))
    page.get_by_role("button", name="Close flight").click()
    page.wait_for_selector("table.figures")
    assert page.evaluate("window.pathgene.map.points[1].x") != goal["x"]
    assert not list(folder.glob("flight*"))


@pytest.mark.long
def test_a_flight_whose_tab_is_closed_is_flown_to_its_end(open_desk):
    page = open_desk()
    folder = take_off(page)
    page.close()
    # Meanwhile, another client watches it.
    other = open_desk()
    panel(other, "Saved plans").click()
    other.get_by_role("button", name=re.compile(r"\(flies\)")).click()
    ready(other, "canyon")
    until(other, lambda: aircraft(other) is not None)
    assert other.evaluate("pathgene.map.paths.length") == 2
    other.close()
    deadline = time.monotonic() + 2 * PATIENCE_MS / 1000
    while not (folder / "flight.gif").exists():
        assert time.monotonic() < deadline
        time.sleep(0.2)
    assert parse_json((folder / "flight.json").read_text())["ended"] == "arrived"
