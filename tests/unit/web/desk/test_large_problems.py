"""Problems with thousands of zones: their links, and the page while it draws them."""

import asyncio
import os
import time

import pytest
from nicegui.testing.user_simulation import user_simulation

from pathgene.host.errors import InputError
from pathgene.host.web.desk import kept
from pathgene.host.web.desk.desk import Desk
from pathgene.host.web.desk.page import Page
from pathgene.host.web.desk.sheet import MOST_BYTES, Sheet


CORNERS = 12


def many(count, corners=CORNERS):
    """Return polygons in rows over a map of 5 km, each of many corners."""
    zones = []
    for number in range(count):
        x, y = 600 + 50.5 * (number % 70), 600 + 50.5 * (number // 70)
        ring = [[x + 0.123456789 * n, y + 20.1 * (n % 2) + 0.1 * n] for n in range(corners)]
        zones.append({"polygon": ring, "name": f"zone {number}", "upper": 900.0})
    return zones


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    desk = Desk(tmp_path_factory.mktemp("desk"))
    desk._first.take_terrain("canyon")
    yield desk
    desk.close()


def large(desk, count=5000):
    sheet = desk.sheet()
    sheet.zones.extend(many(count))
    return sheet


def test_a_link_to_a_large_problem_is_short_and_opens_it(desk):
    sheet = large(desk)
    assert len(sheet.text()) > MOST_BYTES
    with pytest.raises(InputError, match="no whole problem"):
        desk.sheet().open_link(sheet.link())
    link = desk.kept.link(sheet)
    assert len(link) < 40
    assert desk.kept.link(sheet) == link
    other = desk.sheet()
    # Another desk in the same folder, after a restart.
    kept.KeptProblems(desk.directory / "problems").open_link(other, link)
    assert other.text() == sheet.text()
    assert [entry.name for entry in (desk.directory / "problems").iterdir()] == [
        f"{link.removeprefix('kept=')}.toml"
    ]
    assert desk.saved() == []


def test_a_small_problem_is_in_its_link(desk):
    sheet = desk.sheet()
    assert desk.kept.link(sheet) == sheet.link()
    other = Sheet(desk.terrains)
    desk.kept.open_link(other, sheet.link())
    assert other.text() == sheet.text()


@pytest.mark.parametrize(
    "link", ["kept=", "kept=0", f"kept={'0' * 24}", "kept=../../x", f"kept={'0' * 23}/", "kept=\0"]
)
def test_a_link_to_no_kept_problem_is_one_sentence(desk, link):
    with pytest.raises(InputError, match=r"^This desk does not keep the problem of the link; open"):
        desk.kept.open_link(desk.sheet(), link)


def test_a_problem_that_cannot_be_opened_again_has_no_link(desk, monkeypatch):
    monkeypatch.setattr(kept, "MOST_TOML_BYTES", 1_000_001)
    with pytest.raises(
        InputError, match=r"^The problem has more than 1 MB as text, so there is no"
    ):
        desk.kept.link(large(desk))


def test_the_oldest_of_too_many_problems_goes(desk, tmp_path, monkeypatch):
    monkeypatch.setattr(kept, "_MOST", 2)
    problems = kept.KeptProblems(tmp_path)
    links = []
    for number in range(3):
        sheet = desk.sheet()
        sheet.zones.extend(many(8 + number, corners=10_000))
        links.append(problems.link(sheet))
        for place, link in enumerate(links):
            file = tmp_path / f"{link.removeprefix('kept=')}.toml"
            if file.exists():
                os.utime(file, (place, place))
    assert len(list(tmp_path.iterdir())) == 2
    with pytest.raises(InputError, match="does not keep"):
        problems.open_link(desk.sheet(), links[0])
    problems.open_link(desk.sheet(), links[2])


def test_copies_share_no_zone_that_changes(desk):
    sheet = desk.sheet()
    sheet.zones.extend(many(2))
    sheet.via.append((1.0, 2.0, 3.0))
    other = sheet.copy()
    other.reshape(0, {"circle": (1.0, 2.0, 3.0)})
    other.place("via", 9.0, 9.0)
    other.remove_zone(1)
    assert "circle" not in sheet.zones[0]
    assert len(sheet.zones) == 2
    assert sheet.via == [(1.0, 2.0, 3.0)]


def test_drawing_many_zones_leaves_the_loop_to_others(desk):
    """While 5,000 zones are drawn and listed, nothing else waits for half a second."""

    async def drawn():
        pages, gaps = [], []

        async def ticking():
            while True:
                # Processor time of this thread, since a busy machine makes pauses.
                begun_s = time.thread_time()
                await asyncio.sleep(0.01)
                gaps.append(time.thread_time() - begun_s)

        async with user_simulation(lambda: pages.append(Page(desk, "http://desk/"))) as user:
            await user.open("/")
            with user:
                page = pages[-1]
                page._sheet.zones.extend(many(5000))
                ticker = asyncio.create_task(ticking())
                page._show_values()
                begun_s = time.process_time()
                await page._settle()
                took_s = time.process_time() - begun_s
                ticker.cancel()
                assert page._trouble.text == ""
        return max(gaps), took_s

    longest_s, took_s = asyncio.run(drawn())
    print(f"{took_s:.2f} s, longest pause {longest_s:.3f} s")
    assert took_s > 1 > 0.5 > longest_s
