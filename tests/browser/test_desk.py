"""The desk in Chromium: draw, plan, compare, download, reopen; with and without a mouse."""

import json
import re
import signal
import time
import urllib.error
import urllib.request
from urllib.parse import urlsplit

import numpy as np
import pytest

from pathgene.host.inputs import parse_json
from pathgene.host.mission.problem_file import read_problem
from pathgene.host.problem.zones import read_zones
from pathgene.host.report.read import read_run
from pathgene.host.report.run_files import SUMMARY
from tests.browser.desk_page import (
    PATIENCE_MS,
    canyon,
    changed,
    choose,
    panel,
    plan,
    problem_of,
    ready,
    saved,
    serving,
    spot,
    told,
)
from tests.browser.seen import colours, pixels, settle


pytestmark = pytest.mark.ci
VIEWS = ("relief", "plan", "altitude", "fitness")


def test_draw_plan_take_along_and_open_again(open_desk, tmp_path):
    page = open_desk()
    for part in ("relief", "plan"):
        assert colours(pixels(page.locator(f'[data-part="{part}"] canvas'))) > 100, part
    before = page.evaluate("location.hash")
    # A circle on the route, a polygon next to it, a new start.
    page.get_by_role("button", name="Circle", exact=True).click()
    page.mouse.move(*spot(page, 0.5, 0.5))
    page.mouse.down()
    page.mouse.move(*spot(page, 0.55, 0.5), steps=4)
    page.mouse.up()
    before = changed(page, before)
    page.get_by_role("button", name="Polygon", exact=True).click()
    for corner in ((0.2, 0.6), (0.3, 0.6), (0.25, 0.7)):
        page.mouse.click(*spot(page, *corner))
    page.keyboard.press("Enter")
    before = changed(page, before)
    page.get_by_role("button", name="Start", exact=True).click()
    page.mouse.click(*spot(page, 0.15, 0.12))
    before = changed(page, before)
    # The polygon gets heights by its fields.
    page.get_by_label("lower", exact=True).fill("500")
    page.get_by_label("upper", exact=True).fill("900")
    before = changed(page, before)
    values = problem_of(page)
    circle, polygon = values["zones"]
    assert circle["circle"][2] == pytest.approx(0.05 * 29_199, rel=0.05)
    assert len(polygon["polygon"]) == 3
    assert (polygon["lower"], polygon["upper"]) == (500.0, 900.0)
    assert values["start"][0] == pytest.approx(0.15 * 29_199, rel=0.02)

    folder = plan(page)
    # The curve follows the plan, a few generations a frame.
    page.wait_for_selector('[data-role="generation"]:has-text("generation 8,000")')
    settle(page)
    for part in VIEWS:
        least = 100 if part in ("relief", "plan") else 10
        assert colours(pixels(page.locator(f'[data-part="{part}"] canvas'))) > least, part
    files = {}
    for link in page.locator(".files a").all():
        with page.expect_download() as download:
            link.click()
        name = download.value.suggested_filename
        files[name] = tmp_path / name
        download.value.save_as(files[name])
    assert set(files) == {"path.plan", "path.kml", "path.html", "problem.toml"}
    run = read_run(folder / SUMMARY)
    assert run.summary["planner"] == "ga-chip"
    assert len(run.problem.zones) == 2
    items = parse_json(files["path.plan"].read_text())["mission"]["items"]
    # The export leaves out waypoints of the path.
    assert 10 < len(items) < len(run.path) + 10
    for name in ("path.plan", "path.kml"):
        assert len(read_zones(files[name], run.problem.terrain).zones) == 2, name
    assert read_problem(files["problem.toml"])["zones"] == values["zones"]
    assert "<script" in files["path.html"].read_text()

    # Open the link in another browser.
    page.get_by_role("button", name="Link", exact=True).click()
    link = page.get_by_label("link", exact=True).input_value()
    other = open_desk("#" + link.partition("#")[2])
    assert problem_of(other) == values


def test_generations_are_seen_as_they_come_and_a_stopped_plan_is_saved(open_desk):
    page = open_desk(reduced_motion="no-preference")
    canyon(page, generations=10_000_000)
    page.evaluate(
        """() => {
          window.frames_ = [];
          const { map } = window.pathgene;
          const set = map.setPaths.bind(map);
          map.setPaths = (paths) => {
            frames_.push(paths.map(({ opacity }) => opacity));
            set(paths);
          };
        }"""
    )
    page.get_by_role("button", name="Plan", exact=True).click()
    count = page.locator('[data-role="generation"]')
    shown = set()
    deadline = time.monotonic() + 60
    while len(shown) < 5 and time.monotonic() < deadline:
        shown.add(count.text_content())
        page.wait_for_timeout(50)
    assert len(shown) >= 5
    page.get_by_role("button", name="Stop", exact=True).click()
    folder = saved(page)
    assert parse_json((folder / SUMMARY).read_text())["stopped_by"] == "interrupt"
    frames = page.evaluate("frames_")
    trails = [frame for frame in frames if len(frame) > 1]
    assert trails, "no path was drawn over an older one"
    # The latest is fully drawn; older ones fade.
    assert all(frame[-1] == 1 and frame == sorted(frame) for frame in trails if max(frame) == 1)


def test_everything_by_the_keyboard(open_desk):
    page = open_desk()
    canyon(page)
    before = page.evaluate("location.hash")

    def press(name):
        page.get_by_role("button", name=name, exact=True).press("Enter")

    def enter(field, text):
        field.focus()
        page.keyboard.press("Control+a")
        page.keyboard.type(text)

    press("Add via point")
    before = changed(page, before)
    enter(page.get_by_label("Via 1, east m"), "2500")
    enter(page.get_by_label("Via 1, north m"), "1200")
    enter(page.get_by_label("Start, east m"), "350")
    panel(page, "No-fly zones").focus()
    page.keyboard.press("Enter")
    press("Add circle")
    enter(page.get_by_label("Circle, radius m"), "150")
    enter(page.get_by_label("name", exact=True), "tower")
    page.wait_for_function(
        "() => window.pathgene.map.zones.some((zone) => zone.name === 'tower')",
    )
    values = told(
        page,
        via=[(2500.0, 1200.0, 100.0)],
        zones=[{"circle": (2500.0, 2500.0, 150.0), "name": "tower"}],
    )
    assert values["start"][0] == 350.0
    press("Plan")
    run = read_run(saved(page) / SUMMARY)
    assert run.summary["via"][0][:2] == [2500.0, 1200.0]
    # The map and the profile answer keys, too.
    profile = page.locator('[data-part="altitude"] canvas')
    readout = page.locator('[data-part="altitude"] .readout')
    deadline = time.monotonic() + 60
    # The track of the saved plan may arrive a moment after its name.
    while "clear by" not in readout.text_content():
        assert time.monotonic() < deadline
        profile.focus()
        page.keyboard.press("Home")
        page.keyboard.press("ArrowRight")
        page.wait_for_timeout(200)
    press("Remove via 1")
    page.wait_for_function("() => window.pathgene.map.points.length === 2")


def test_every_control_has_a_name_and_is_reached_by_tab(open_desk):
    page = open_desk()
    names = page.evaluate(
        """() => [...document.querySelectorAll("button, input, [tabindex='0']")]
          .filter((node) => node.offsetParent && !node.closest(".hidden"))
          .map((node) => node.getAttribute("aria-label") || node.textContent.trim()
            || node.closest("label")?.textContent || node.placeholder || node.outerHTML)"""
    )
    assert len(names) > 25
    assert [name for name in names if name.startswith("<")] == []
    reached = set()
    for _ in range(80):
        page.keyboard.press("Tab")
        reached.add(
            page.evaluate(
                "document.activeElement.getAttribute('aria-label')"
                " || document.activeElement.textContent.trim()"
            )
        )
    for name in ("Plan", "Move", "Polygon", "Altitude profile", "Link", "Start, north m"):
        assert name in reached, name


def test_two_plans_side_by_side(open_desk):
    page = open_desk()
    canyon(page)
    first = plan(page)
    page.get_by_role("button", name="Keep to compare").click()
    choose(page, "planner", "astar")
    told(page, planner="astar")
    page.get_by_role("button", name="Plan", exact=True).click()
    page.wait_for_function(
        "() => document.querySelectorAll('table.figures thead th').length === 3"
        " && document.querySelector('table.figures').textContent.includes('astar')",
    )
    rows = {
        row.locator("th").text_content(): [cell.text_content() for cell in row.locator("td").all()]
        for row in page.locator("table.figures tbody tr").all()
    }
    assert rows["Planner"] == ["astar", "ga-pc"]
    kept = parse_json((first / SUMMARY).read_text())
    assert rows["Fitness"][1] == f"{kept['fitness']:.4f}"
    assert rows["Fitness"][0] != rows["Fitness"][1]
    settle(page)
    drawn = page.evaluate("window.pathgene.map.paths.map(({ colour }) => colour)")
    assert {"path", "#d55e00"} <= set(drawn)
    page.get_by_role("button", name="Drop kept").click()
    page.wait_for_function("() => window.pathgene.map.paths.every(p => p.colour !== '#d55e00')")


def test_a_closed_tab_loses_nothing(open_desk, desk):
    page = open_desk()
    canyon(page, generations=3000)
    before = set(desk[1].iterdir())
    page.get_by_role("button", name="Plan", exact=True).click()
    page.wait_for_selector("text=Planning")
    page.close()
    deadline = time.monotonic() + 120
    while not (new := [file for file in desk[1].glob(f"*/{SUMMARY}") if file.parent not in before]):
        assert time.monotonic() < deadline, "the plan of the closed tab was not saved"
        time.sleep(0.2)
    name = new[0].parent.name
    assert read_run(new[0]).summary["stopped_by"] == "generations"
    other = open_desk()
    panel(other, "Saved plans").click()
    other.get_by_role("button", name=name, exact=True).click()
    ready(other, "canyon")
    other.wait_for_selector("table.figures")
    assert problem_of(other)["generations"] == 3000


def test_files_are_opened_by_what_they_are(open_desk, tmp_path):
    page = open_desk()
    canyon(page)
    zones = tmp_path / "zones.geojson"
    zones.write_text(
        json.dumps(
            {
                "type": "FeatureCollection",
                "crs_local": True,
                "features": [
                    {
                        "type": "Feature",
                        "properties": {"radius_m": 300, "name": "lake"},
                        "geometry": {"type": "Point", "coordinates": [2000, 2000]},
                    }
                ],
            }
        )
    )
    y, x = np.mgrid[:80, :120]
    land = tmp_path / "my land.npz"
    np.savez(land, elevation=100 + 30 * np.sin(x / 9) * np.cos(y / 7), dx_m=50.0, dy_m=50.0)
    bad = tmp_path / "bad.toml"
    bad.write_text("[terrain]\nsource = '/etc/passwd'\n")

    def give(file):
        page.locator("input[type=file]").set_input_files(file)

    give(zones)
    page.wait_for_function("() => window.pathgene.map.zones[0]?.name === 'lake'")
    give(bad)
    page.wait_for_selector("text=The terrain 'passwd' is not on this desk")
    give(land)
    page.wait_for_function("() => window.pathgene.map.terrain.name.startsWith('my-land-')")
    assert problem_of(page)["terrain"].startswith("my-land-")
    plan(page)


@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.long)])
def test_it_fits_a_small_screen(open_desk, scheme):
    page = open_desk(width=390, height=800, color_scheme=scheme)
    wide = page.evaluate("document.documentElement.scrollWidth")
    assert wide <= 390
    paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
    light = sum(map(int, re.findall(r"\d+", paper)[:3])) > 3 * 128
    assert light is (scheme == "light")
    for part in ("plan", "relief"):
        box = page.locator(f'[data-part="{part}"] canvas').bounding_box()
        assert box["width"] > 300
        assert box["height"] > 250


def test_without_the_token_nothing_answers(desk):
    url = urlsplit(desk[0])
    base = f"http://{url.netloc}"
    for path in (
        "/",
        "/?token=wrong",
        "/_nicegui_ws/socket.io/?EIO=4&transport=polling",
        "/plans/a/b",
    ):
        with pytest.raises(urllib.error.HTTPError) as caught:
            urllib.request.urlopen(base + path)
        assert caught.value.code == 403, path
        assert b"open the whole address" in caught.value.read()


def test_the_end_of_the_desk_saves_running_plans(new_page, tmp_path):
    with serving(tmp_path / "out") as (url, process):
        page = new_page(reduced_motion="reduce")
        page.set_default_timeout(PATIENCE_MS)
        page.goto(url)
        ready(page)
        canyon(page, generations=10_000_000)
        page.get_by_role("button", name="Plan", exact=True).click()
        page.wait_for_function(
            "() => document.querySelector('[data-role=generation]').textContent",
        )
        page.goto("about:blank")
        process.send_signal(signal.SIGTERM)
        assert process.wait(60) == 128 + signal.SIGTERM
    (file,) = (tmp_path / "out").glob(f"*/{SUMMARY}")
    assert read_run(file).summary["stopped_by"] == "interrupt"
