"""The page of a checked mission in Chromium: its list of faults, and their marks."""

import pytest

from pathgene.host.problem.zones import Circle
from pathgene.host.web.mission_page import page_of_check
from tests.browser.seen import settle
from tests.support.host.foreign import PLAIN, checked, item, land, plan_of


ZONE = (4500.0, 3000.0)


@pytest.mark.ci
def test_a_click_on_a_fault_marks_its_place_in_all_views(new_page, tmp_path):
    items = [item(16, (900, 1500), 420), item(16, (4500, 1500), 420), item(16, (4500, 4500), 420)]
    # Flown on its own after the landing.
    items += [item(21, (3000, 5000), 300), item(16, (2000, 5000), 420), item(16, (900, 4000), 420)]
    zones = (Circle(*ZONE, 200.0, name="mast"),)
    check = checked(land(PLAIN), tmp_path / "m.plan", plan_of(items), zones=zones)
    numbers = [table["number"] for table in check.tables if table["limit"] == "zone mast"]
    file = tmp_path / "check.html"
    file.write_text(page_of_check(check, "m.plan"), encoding="utf-8")
    page = new_page(1280, 720)
    page.goto(file.as_uri())
    page.wait_for_selector("html[data-ready]", timeout=60_000)
    rows = page.locator("#faults button").all_text_contents()
    assert rows == [table["sentence"] for table in check.tables]
    page.locator("#faults button").nth(numbers[0] - 1).click()
    settle(page)
    marked = page.evaluate("() => [pathgene.map.marked.x, pathgene.map.marked.y]")
    assert marked == pytest.approx(ZONE, abs=210)
    colour = page.evaluate(
        """([x, y]) => {
          const { map } = pathgene;
          const context = map.canvas.node.getContext("2d");
          map.mark(null);
          map.draw(context);
          // Beside the red line to the north, and inside the mark.
          const [left, top] = map.pixelsAt(x, y);
          const scale = map.canvas.node.width / map.canvas.width;
          return [...context.getImageData((left + 2.8) * scale, top * scale, 1, 1).data];
        }""",
        list(check.faults[numbers[0] - 1].place[:2]),
    )
    assert colour[0] > 180
    assert max(colour[1:3]) < 90
    parts = page.evaluate("() => pathgene.map.paths.filter(({ curtain }) => curtain).length")
    assert parts == 2
