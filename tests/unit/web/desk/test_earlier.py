"""A plan on the page after a change of its problem, in NiceGUI's simulation of a user."""

import asyncio
import time

import pytest
from nicegui import ElementFilter, ui

from pathgene.host.web.desk.desk import Desk
from pathgene.host.web.desk.results import EARLIER
from pathgene.host.web.desk.stage import Stage
from tests.unit.web.desk.test_page import entered, opened, press_plan


def drawn(what, **values):
    """Return a function that draws on the map."""

    def draw(user, page):
        user.find(Stage).trigger("drawn", {"what": what, **values})

    return draw


def typed(name, text):
    """Return a function that types into a field of the form."""

    async def type_(user, page):
        (await entered(page, ("form", name)))["form", name].value = text

    return type_


def chosen(label, value):
    """Return a function that chooses a value."""

    def choose(user, page):
        (select,) = (each for each in ElementFilter(kind=ui.select) if each.props["label"] == label)
        select.value = value

    return choose


def switched(label, value):
    """Return a function that switches something on or off."""

    def switch(user, page):
        (each,) = (each for each in ElementFilter(kind=ui.switch) if each.text == label)
        each.value = value

    return switch


#: A change, and the change back if there is one.
CHANGES = {
    "zone drawn": (drawn("zone", circle=[2500, 2500, 300]), None),
    "zone reshaped": (
        drawn("reshape", number=0, circle=[4000, 500, 120]),
        drawn("reshape", number=0, circle=[4000, 500, 100]),
    ),
    "start moved": (
        drawn("place", name="start", number=0, x=600, y=700),
        drawn("place", name="start", number=0, x=500, y=500),
    ),
    "goal moved": (drawn("place", name="goal", number=0, x=4000, y=4100), None),
    "via point": (drawn("via", x=2000, y=2200), None),
    "wind": (typed("wind", "3, 0"), typed("wind", "")),
    "clearance": (typed("clearance", "35"), typed("clearance", "")),
    "no number": (typed("clearance", "fifty"), typed("clearance", "")),
    "aircraft": (chosen("aircraft", "heron"), chosen("aircraft", None)),
    "return": (switched("return", True), switched("return", False)),
    "terrain": (chosen("terrain", "river"), None),
}


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    desk = Desk(tmp_path_factory.mktemp("desk"))
    sheet = desk._first
    sheet.take_terrain("canyon")
    sheet.place("start", 500, 500)
    sheet.set("planner", "astar")
    sheet.zones.append({"circle": (4000.0, 500.0, 100.0)})
    yield desk
    desk.close()


@pytest.fixture(scope="module")
def saved(desk):
    """Name of a saved plan."""
    job = desk.plan(desk.sheet())
    deadline = time.monotonic() + 120
    while not job.done:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    assert job.state == "saved"
    assert job.summary["feasible"]
    return job.folder.name


async def offered():
    """Return whether the page offers a flight, its links to files, and its verdict."""
    await asyncio.sleep(0.1)
    buttons = [
        each for each in ElementFilter(kind=ui.button) if each.text == "Fly" and each.visible
    ]
    links = [each.props["download"] for each in ElementFilter() if each.tag == "a"]
    texts = [each.text for each in ElementFilter(kind=ui.label)]
    verdict = [text for text in texts if "feasible" in text]
    return [each.enabled for each in buttons], links, verdict, EARLIER in texts


FILES = ["path.html", "problem.toml"]


#: The changes that `make test` tries; `make test-ci` tries all.
QUICK = ("zone drawn", "goal moved", "wind")


@pytest.mark.parametrize(
    ("change", "back"),
    [
        pytest.param(*both, id=name, marks=[] if name in QUICK else [pytest.mark.ci])
        for name, both in CHANGES.items()
    ],
)
def test_a_plan_of_an_earlier_problem_is_marked_and_locked(desk, saved, change, back):
    async def run(act, user, page):
        if asyncio.iscoroutine(doing := act(user, page)):
            await doing

    async def use():
        async with opened(desk, "astar") as (user, page):
            assert await page._load(saved)
            whole = await offered()
            assert whole[0] == [True]
            assert set(whole[1]) >= set(FILES)
            assert whole[2:] == (["✓ feasible"], False)
            await run(change, user, page)
            for _ in range(100):
                flights, links, verdict, is_marked = await offered()
                if is_marked or page._results.plan is None:
                    break
            assert True not in flights
            assert links == []
            assert "✓ feasible" not in verdict
            await page.fly()
            assert desk.jobs.active == []
            if back is not None:
                await run(back, user, page)
                assert await offered() == whole

    asyncio.run(use())


def test_the_planner_is_no_part_of_the_problem_and_another_plan_unlocks(desk, saved):
    """The planner may change before a flight, in which it plans."""

    async def use():
        async with opened(desk, "astar") as (user, page):
            assert await page._load(saved)
            chosen("planner", "fpa-2opt")(user, page)
            assert (await offered())[0] == [True]
            chosen("planner", "astar")(user, page)
            drawn("zone", circle=[2500, 2500, 300])(user, page)
            assert (await offered())[0] == [False]
            await press_plan(user, page)
            for _ in range(600):
                flights, links, _, is_marked = await offered()
                if flights:
                    break
            assert flights == [True]
            assert set(links) >= set(FILES)
            assert not is_marked

    asyncio.run(use())


def test_a_change_while_a_plan_is_made_is_no_part_of_it(desk):
    async def use():
        async with opened(desk, "astar") as (user, page):
            await press_plan(user, page)
            (job,) = desk.jobs.active
            drawn("zone", circle=[2500, 2500, 300])(user, page)
            for _ in range(600):
                flights, links, _, is_marked = await offered()
                if flights:
                    break
            assert (flights, links, is_marked) == ([False], [], True)
            assert len(job.values["zones"]) == 1
            assert len(job.summary["nofly"]) == 1

    asyncio.run(use())
