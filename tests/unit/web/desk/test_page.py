"""The page of the desk in NiceGUI's simulation of a user: texts without a value."""

import asyncio
import contextlib

import pytest
from nicegui import ElementFilter, ui
from nicegui.testing.user_simulation import user_simulation

from pathgene.host.planners import PLANNERS
from pathgene.host.web.desk.desk import Desk
from pathgene.host.web.desk.fields import Input
from pathgene.host.web.desk.form import GROUPS, ZONE_FIELDS, fields_of, planner_fields
from pathgene.host.web.desk.page import Page


CIRCLE = {"circle": (2000.0, 2000.0, 100.0)}
POLYGON = {"polygon": [[3000.0, 3000.0], [3200.0, 3000.0], [3100.0, 3100.0]]}
# Not in a field for numbers or for a board.
NONSENSE = "fifty, about 5 m/s NW"


def texts(fields, *place):
    """Return the places of the fields that take a text; each text is a name of a zone."""
    typed = [field for field in fields if field.widget in ("number", "text")]
    return [(*place, field.option.name) for field in typed if field.option.key != "name"]


def places():
    """Return the place of every field of the page, and a planner that has it."""
    shapes = [("zone", 0, "circle", part) for part in range(3)] + [("zone", 1, "polygon")]
    ends = [(end, part) for end in ("start", "goal") for part in range(3)]
    via = [("via", 0, part) for part in range(3)]
    zones = [place for number in (0, 1) for place in texts(ZONE_FIELDS, "zone", number)]
    form = [place for table in GROUPS for place in texts(fields_of(table), "form")]
    found = dict.fromkeys(shapes + ends + via + zones + form, "ga-chip")
    for name in PLANNERS:
        for place in texts(planner_fields(name), "form"):
            found.setdefault(place, name)
    return found


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    desk = Desk(tmp_path_factory.mktemp("desk"))
    desk._first.take_terrain("canyon")
    desk._first.add_via(2500.0, 1000.0)
    desk._first.zones.extend([CIRCLE, POLYGON])
    yield desk
    desk.close()


@contextlib.asynccontextmanager
async def opened(desk, planner="ga-chip"):
    """Open the page with a planner; yield its user, and the page."""
    pages, errors = [], []
    async with user_simulation(lambda: pages.append(Page(desk, "http://desk/"))) as user:
        await user.open("/")
        with user:
            page = pages[-1]
            page._planner.set_value(planner)
            await page._settle()
            try:
                yield user, page
            except BaseException as error:
                # The simulation ends by itself only if nothing is raised in it.
                errors.append(error)
    for error in errors:
        raise error


async def entered(page, place):
    """Return the fields of the page by place, with a zone opened if the place is in one."""
    page._panels.pick(place[1] if place[0] == "zone" else None)
    await asyncio.sleep(0)
    return {field.entry.place: field for field in ElementFilter(kind=Input)}


async def press_plan(user, page):
    """Press the button, and wait until the desk has answered."""
    user.find(kind=ui.button, content="Plan").click()
    for _ in range(200):
        await asyncio.sleep(0.02)
        if page._trouble.text or page._desk.jobs.active:
            return
    raise AssertionError("no answer")


def places_of(planner):
    """Return the places to try on a page with this planner."""
    return [place for place, name in places().items() if name == planner]


@pytest.mark.parametrize("planner", [name for name in PLANNERS if places_of(name)])
def test_a_text_that_is_not_understood_is_shown_and_not_planned(desk, planner):
    """Every field is tried in turn, on one page."""

    async def enter(user, page, place):
        field = (await entered(page, place))[place]
        before = field.value
        field.value = NONSENSE
        assert field.error, place
        assert field.props["error"] is True, place
        await press_plan(user, page)
        assert desk.jobs.active == [], place
        assert field.error in page._trouble.text, place
        # It is still there after its panel was shown again.
        page._panels.show_form()
        page._panels.show_drawn()
        field = (await entered(page, place))[place]
        assert (field.value, bool(field.error)) == (NONSENSE, True), place
        field.value = before
        assert field.error is None, place
        await page._settle()
        # A later change of the page may still be drawn.
        for _ in range(500):
            if page._trouble.text == "":
                break
            await asyncio.sleep(0.01)
        assert page._trouble.text == "", place

    async def enter_all():
        async with opened(desk, planner) as (user, page):
            for place in places_of(planner):
                await enter(user, page, place)

    asyncio.run(enter_all())


def test_the_page_has_no_other_fields_of_texts(desk):
    """A field that is added to the page is in the test above."""

    async def seen():
        found = set()
        for planner in PLANNERS:
            async with opened(desk, planner) as (_, page):
                for zone in (0, 1):
                    found |= set(await entered(page, ("zone", zone)))
        return found

    names = {("zone", number, "name") for number in (0, 1)}
    assert asyncio.run(seen()) == set(places()) | names
