"""Actions of a user on the page of the desk, for its tests."""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

from pathgene.host.mission.problem_file import parse_problem
from tests.browser.seen import settle
from tests.support.host.processes import Started


PATIENCE_MS = 120_000


@contextlib.contextmanager
def serving(folder, *arguments):
    """Serve a desk in a separate process; yield its address and the process."""
    command = [sys.executable, "-m", "pathgene", "desk", "--out", folder, "--json", *arguments]
    # NiceGUI behaves differently within pytest.
    environment = {key: value for key, value in os.environ.items() if "PYTEST" not in key}
    desk = Started(
        [str(each) for each in command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        cwd=Path(__file__).resolve().parents[2],
    )
    try:
        lines = [desk.stdout.readline() for _ in range(4)]
        assert lines[-1].strip() == "}", desk.communicate()[1]
        yield json.loads("".join(lines))["url"], desk
    finally:
        desk.send_signal(signal.SIGINT)
        try:
            desk.communicate(timeout=60)
        finally:
            desk.kill()


def ready(page, terrain=None):
    name = f'="{terrain}"' if terrain else ""
    page.wait_for_selector(f".stage[data-ready{name}]")
    settle(page)


def choose(page, label, value):
    page.get_by_label(label, exact=True).click()
    page.get_by_role("option", name=value, exact=True).click()


def panel(page, name):
    return page.locator("summary", has_text=re.compile(f"^{name}$"))


def canyon(page, **fields):
    """Select a small terrain and a quick planner."""
    choose(page, "terrain", "canyon")
    ready(page, "canyon")
    choose(page, "planner", "ga-pc")
    # The fields of the previous planner must be gone.
    told(page, planner="ga-pc")
    panel(page, "Planner").click()
    fields = {"generations": 40, **fields}
    for label, value in fields.items():
        page.get_by_label(label, exact=True).fill(str(value))
    told(page, **fields)


def plan(page):
    page.get_by_role("button", name="Plan", exact=True).click()
    return saved(page)


def saved(page):
    """Wait for the plan, and return its folder."""
    page.wait_for_selector("text=Saved in")
    return Path(page.locator(".status").text_content().removeprefix("Saved in "))


def spot(page, x, y):
    """Return the screen position of a point given as shares of the map's sides."""
    return page.evaluate(
        """([x, y]) => {
          const { map } = window.pathgene;
          const box = map.canvas.node.getBoundingClientRect();
          const { width_m, height_m } = map.terrain;
          const [left, top] = map.pixelsAt(x * width_m, y * height_m);
          return [box.left + left, box.top + top];
        }""",
        [x, y],
    )


def told(page, **expected):
    """Wait until the page's problem has these values; return all of them."""
    deadline = time.monotonic() + PATIENCE_MS / 1000
    while True:
        values = problem_of(page)
        if all(values.get(key) == value for key, value in expected.items()):
            return values
        assert time.monotonic() < deadline, (expected, values)
        page.wait_for_timeout(100)


def problem_of(page):
    """Return the values of the problem file that the page downloads."""
    with page.expect_download() as download:
        page.get_by_role("button", name="Problem file").click()
    return parse_problem(Path(download.value.path()).read_text(), Path())


def changed(page, before):
    """Wait until the address has a different problem; return the problem."""
    page.wait_for_function("before => location.hash !== before", arg=before)
    return page.evaluate("location.hash")
