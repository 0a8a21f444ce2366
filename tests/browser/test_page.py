"""The page of a plan in Chromium: its drawings, its linked views, and its fit on screens."""

import re
import socket

import numpy as np
import pytest

from pathgene.host.web.page import page_of
from tests.browser.seen import colours, is_local, pixels, settle
from tests.support.host.web_plans import KINDS, evaluated, hills, page_text, planned, with_mission


VIEWS = ("#relief", "#plan", "#altitude")


@pytest.fixture
def opened(new_page, tmp_path):
    """Function that opens the page of a kind of plan, or a given one."""

    def open_file(kind, width=1280, height=720, *, text=None, **options):
        file = tmp_path / "path.html"
        file.write_text(text or page_text(kind), encoding="utf-8")
        page = new_page(width, height, **options)
        page.goto(file.as_uri())
        page.wait_for_selector("html[data-ready]", timeout=60_000)
        settle(page)
        return page

    return open_file


def place(page):
    """The figures of the marked place."""
    return {
        cell.get_attribute("data-figure"): cell.text_content()
        for cell in page.locator("#place dd").all()
    }


def still(page):
    """Wait until the 3-D view is still, because a slow machine draws movements coarsely."""
    page.evaluate(
        """() => new Promise((done) => {
          const { view } = pathgene;
          const look = () => (view.frame || view.coarse ? setTimeout(look, 30) : done());
          setTimeout(look, 30);
        })"""
    )
    settle(page)


def metres_of(text):
    """Metres of a text like 1.25 km."""
    value, unit = re.fullmatch(r"(-?[\d,.]+) (k?m)", text).groups()
    return float(value.replace(",", "")) * (1000 if unit == "km" else 1)


@pytest.mark.ci
def test_all_views_draw_and_the_pointer_over_the_profile_marks_them(opened):
    page = opened("plain")
    shown = {view: pixels(page.locator(f"{view} canvas")) for view in VIEWS}
    # A blank canvas has one colour, a canvas with only its gradient a few.
    assert colours(shown["#relief"]) > 100
    assert colours(shown["#plan"]) > 100
    assert colours(shown["#altitude"]) > 15
    assert page.locator("#verdict").text_content() == "✓ Feasible"

    least = planned("plain").evaluation.minimum_clearance_m
    assert metres_of(place(page)["clearance"]) == pytest.approx(least, abs=0.05)
    before = place(page)
    box = page.locator("#altitude canvas").bounding_box()
    page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 0.5 * box["height"])
    settle(page)
    after = place(page)
    assert after["distance"] != before["distance"]
    for view in VIEWS:
        moved = np.abs(pixels(page.locator(f"{view} canvas")) - shown[view]).max(axis=2) > 0.3
        # The mark has moved, and nothing else has changed.
        assert 20 < moved.sum() < 0.05 * moved.size, view

    samples = planned("plain").evaluator.track(planned("plain").path).sample(1.0)
    flown = metres_of(after["distance"])
    altitude, ground = (
        np.interp(flown, samples.s, values) for values in (samples.z, samples.ground)
    )
    assert metres_of(after["altitude"]) == pytest.approx(altitude, abs=3)
    assert metres_of(after["height"]) == pytest.approx(altitude - ground, abs=5)


@pytest.mark.ci
def test_the_end_of_a_mission_is_drawn_on_map_and_relief(opened):
    plan = with_mission()
    page = opened("", text=page_of(plan.evaluator, plan.path, plan.summary))
    assert "triangles its rally points" in page.locator("#notes").text_content()
    still(page)
    shown = {view: pixels(page.locator(f"{view} canvas")) for view in VIEWS[:2]}
    page.evaluate(
        """() => {
          const paths = pathgene.map.paths.filter(({ thin }) => !thin);
          pathgene.map.setPaths(paths);
          pathgene.view.setPaths(paths);
        }"""
    )
    still(page)
    for view, before in shown.items():
        changed = np.abs(pixels(page.locator(f"{view} canvas")) - before).max(axis=2) > 0.2
        # Thin lines and small marks.
        assert 100 < changed.sum() < 0.05 * changed.size, view


@pytest.mark.ci
def test_the_keyboard_does_all_that_the_pointer_does(opened):
    page = opened("mission")
    page.locator("#altitude canvas").focus()
    page.keyboard.press("Home")
    assert metres_of(place(page)["distance"]) == 0
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    length = planned("mission").evaluation.length_m
    assert metres_of(place(page)["distance"]) == pytest.approx(length / 100, rel=0.01)
    page.keyboard.press("End")
    assert metres_of(place(page)["distance"]) == pytest.approx(length, abs=6)
    slider = page.get_by_role("slider")
    assert slider.get_attribute("aria-valuenow") == str(round(length))
    assert "flown, altitude" in slider.get_attribute("aria-valuetext")
    page.keyboard.press("Escape")
    assert set(place(page).values()) == {"–"}

    for view, keys in (
        ("#relief", ("ArrowLeft", "+", "Shift+ArrowUp")),
        ("#plan", ("+", "ArrowUp")),
    ):
        canvas = page.locator(f"{view} canvas")
        canvas.focus()
        first = last = pixels(canvas)
        for key in keys:
            page.keyboard.press(key)
            still(page)
            now = pixels(canvas)
            assert np.abs(now - last).mean() > 0.002, (view, key)
            last = now
        page.keyboard.press("0")
        still(page)
        assert np.abs(pixels(canvas) - first).mean() < 0.002, view


@pytest.mark.ci
def test_the_pointer_over_the_map_marks_the_nearest_place(opened):
    page = opened("plain")
    x, y = page.evaluate(
        """() => {
          const { map, scene } = pathgene;
          const { track } = scene.paths[0];
          const i = Math.floor(track.samples / 3);
          const box = map.canvas.node.getBoundingClientRect();
          const [left, top] = map.pixelsAt(track.x[i], track.y[i]);
          const event = { clientX: box.left + left, clientY: box.top + top };
          const back = map.metresAt(event);
          if (Math.hypot(back.x - track.x[i], back.y - track.y[i]) > 1) throw Error("metresAt");
          return [event.clientX, event.clientY];
        }"""
    )
    page.mouse.move(x, y)
    settle(page)
    expected = page.evaluate(
        """() => {
          const { track } = pathgene.scene.paths[0];
          return track.s[Math.floor(track.samples / 3)];
        }"""
    )
    assert metres_of(place(page)["distance"]) == pytest.approx(expected, abs=30)


@pytest.mark.ci
def test_a_desk_can_draw_on_the_views(opened):
    page = opened("plain")
    before = {view: pixels(page.locator(f"{view} canvas")) for view in ("#relief", "#plan")}
    page.evaluate(
        """() => {
          const { view, map, scene } = pathgene;
          map.panning = false;
          map.overlays.add((context, own) => {
            context.fillStyle = "#00ff00";
            context.fillRect(...own.pixelsAt(500, 2000), 40, 40);
          });
          const points = [[200, 2200, 500], [2800, 200, 500]];
          const path = { points, colour: "#ff0000", opacity: 0.5 };
          for (const part of [view, map]) {
            part.setPaths([path]);
            part.setZones([]);
            part.setPoints(scene.points.slice(0, 1));
            part.setAircraft({ x: 1500, y: 1200, z: 500, heading_deg: 45 });
            part.mark(null);
          }
        }"""
    )
    settle(page)
    for view, image in before.items():
        now = pixels(page.locator(f"{view} canvas"))
        assert (np.abs(now - image).max(axis=2) > 0.3).sum() > 500, view
    green = pixels(page.locator("#plan canvas")) @ np.array([-1, 1, -1])
    assert (green > 0.9).sum() > 1500
    page.evaluate(
        "() => { for (const name of ['view', 'map', 'profile']) pathgene[name].dispose(); }"
    )
    assert page.locator("canvas").count() == 0


def test_the_guard_notices_a_request():
    assert is_local("http://localhost:8080/x")
    assert is_local("data:text/plain,x")
    assert not is_local("https://example.org/three.js")


@pytest.mark.ci
def test_the_guard_notices_a_websocket(new_page):
    page = new_page()
    page.goto("about:blank")
    with socket.create_server(("127.0.0.1", 0)) as server:
        urls = [
            "ws://192.0.2.1/x",
            "wss://localhost.example.org/x",
            f"ws://127.0.0.1:{server.getsockname()[1]}/x",
        ]
        page.evaluate("urls => { for (const url of urls) new WebSocket(url); }", urls)
        # The request to this machine arrives.
        server.settimeout(30)
        server.accept()[0].close()
    page.wait_for_timeout(100)
    faults = [each for each in new_page.faults if "a WebSocket to" in each]
    assert faults == [f"a WebSocket to {url}" for url in urls[:2]]
    new_page.faults.clear()


@pytest.mark.ci
@pytest.mark.parametrize(
    "kind",
    [pytest.param(kind, marks=[pytest.mark.long] if kind == "voids" else []) for kind in KINDS],
)
def test_every_kind_of_plan_is_drawn(opened, kind):
    page = opened(kind)
    for view in VIEWS:
        assert colours(pixels(page.locator(f"{view} canvas"))) > 15, view
    feasible = planned(kind).evaluation.feasible
    assert page.locator("#verdict").text_content() == (
        "✓ Feasible" if feasible else "✗ Not feasible"
    )
    sentence = page.locator("#sentence")
    assert sentence.is_visible() is (kind == "not feasible")
    figures = {
        cell.get_attribute("data-key"): cell.text_content()
        for cell in page.locator("#figures dd").all()
    }
    assert metres_of(figures["length_m"]) == pytest.approx(
        planned(kind).summary["length_m"], rel=0.005
    )


@pytest.mark.ci
# No rule of the page is for one size in one scheme.
@pytest.mark.parametrize(
    ("width", "height", "scheme"),
    [(1280, 720, "light"), (1920, 1080, "dark"), (390, 800, "dark"), (320, 640, "light")],
)
def test_a_page_fits_its_screen(opened, width, height, scheme):
    page = opened("mission", width, height, color_scheme=scheme)
    wide, high = page.evaluate(
        "() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
    )
    assert wide <= width
    if width > 820:
        assert high <= height
    for view in VIEWS:
        canvas = page.locator(f"{view} canvas")
        box = canvas.bounding_box()
        assert box["width"] > 0.75 * min(width, 400)
        assert box["height"] > 120
        canvas.scroll_into_view_if_needed()
        assert colours(pixels(canvas)) > 10
    paper = pixels(page.locator("header")).mean()
    assert bool(paper > 0.7) is (scheme == "light")


@pytest.mark.ci
def test_large_land_is_drawn_thinned_and_says_so(opened):
    evaluator, path = evaluated(hills(700, 1100))
    page = opened("", text=page_of(evaluator, path, {"terrain": {"name": "large"}}))
    assert "512 × 512 of 1,100 × 700 nodes" in page.locator("#notes").text_content()
    assert colours(pixels(page.locator("#relief canvas"))) > 100
    assert page.locator("#verdict").text_content() == "No verdict"


# A browser without WebGL returns no context for it.
NO_WEBGL = """
const own = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
  return kind.startsWith("webgl") ? null : own.call(this, kind, ...rest);
};
"""


@pytest.mark.ci
def test_without_webgl_the_page_says_so_and_shows_the_rest(new_page, tmp_path):
    page = new_page()
    page.add_init_script(NO_WEBGL)
    file = tmp_path / "path.html"
    file.write_text(page_text("plain"), encoding="utf-8")
    page.goto(file.as_uri())
    page.wait_for_selector("html[data-ready]")
    settle(page)
    assert "draws nothing in 3-D" in page.locator("#relief").text_content()
    assert colours(pixels(page.locator("#plan canvas"))) > 100
    assert colours(pixels(page.locator("#altitude canvas"))) > 15
    page.locator("#altitude canvas").focus()
    page.keyboard.press("End")
    length = planned("plain").evaluation.length_m
    assert metres_of(place(page)["distance"]) == pytest.approx(length, abs=6)
    # three.js repeats the page's message on the console.
    assert all("WebGL" in fault for fault in new_page.faults)
    new_page.faults.clear()
