"""The desk in Chromium without a graphics card: time to show, 3-D frames, generations seen."""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from bench.report import Options, Report
from pathgene.host.errors import JobError


if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page


_ROOT = Path(__file__).parents[1]
_WIDTH, _HEIGHT = 1280, 720
_LOADS = 9
_MOMENTS = ("the page has loaded", "the map is shown", "3-D is shown, too")
_SECONDS = 5.0
_LIMIT_MS = 120_000
#: WebGL is rendered by the processor.
_OPTIONS = ("--enable-unsafe-swiftshader", "--use-angle=swiftshader")
_MAP, _READY = ".stage canvas", ".stage[data-ready]"

_NODES, _NODE_M = 512, 60.0
_PROBLEM = """
[terrain]
source = "land.npz"

[mission]
start = [2000, 2000, 300]
goal = [28000, 28000, 300]
agl = true

[planner]
name = "ga-pc"
generations = 10_000_000
"""

# Turns the eye with every frame; returns the frames that were drawn.
_TURN = """async (seconds) => {
  const { view } = globalThis.pathgene;
  const render = view.render;
  let frames = 0;
  view.render = (...given) => {
    frames += 1;
    return render.apply(view, given);
  };
  const end = performance.now() + 1000 * seconds;
  while (performance.now() < end) {
    view.eye.turn(0.2, 0);
    view.request(true);
    await new Promise((done) => requestAnimationFrame(done));
  }
  view.render = render;
  return frames;
}"""


def run(options: Options) -> Report:
    """Measure the desk on a terrain of 512 x 512 nodes."""
    report = Report(
        f"The desk at {_WIDTH} x {_HEIGHT}, a terrain of {_NODES} x {_NODES}",
        ("what", "measured"),
        notes=[
            "Chromium without a graphics card: the processor draws, and plans at the same time."
        ],
    )
    program = shutil.which("chromium")
    if program is None or importlib.util.find_spec("playwright") is None:
        report.notes.append("Not measured: Chromium or the package playwright is not there.")
        return report
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        _write(Path(folder))
        # Root, as in a container, has no sandbox.
        flags = [*_OPTIONS, *(["--no-sandbox"] if os.geteuid() == 0 else [])]
        browser = playwright.chromium.launch(executable_path=program, args=flags)
        with _serving(Path(folder)) as url:
            loads = [_loads_s(browser, url) for _ in range(_LOADS)]
            page = _new_page(browser)
            page.goto(url)
            page.wait_for_selector(_READY)
            frames = page.evaluate(_TURN, _SECONDS) / _SECONDS
            generations = _generations(page) / _SECONDS
        browser.close()
    report.rows += [
        *(
            (f"seconds until {what}", median(seconds))
            for what, seconds in zip(_MOMENTS, zip(*loads, strict=True), strict=True)
        ),
        ("frames a second in 3-D while it turns", frames),
        ("generations a second of a plan that are counted", generations),
    ]
    return report


def _write(folder: Path) -> None:
    """Write the terrain and the problem."""
    y, x = np.mgrid[:_NODES, :_NODES]
    heights = 800 + 500 * np.sin(x / 40) * np.cos(y / 30) + 120 * np.sin(x / 7 + y / 11)
    np.savez(folder / "land.npz", elevation=heights, dx_m=_NODE_M, dy_m=_NODE_M)
    (folder / "problem.toml").write_text(_PROBLEM, encoding="utf-8")


@contextlib.contextmanager
def _serving(folder: Path) -> Iterator[str]:
    """Serve the desk; yield its address."""
    command = [sys.executable, "-m", "pathgene", "desk", str(folder / "problem.toml"), "--json"]
    with subprocess.Popen(
        [*command, "--out", str(folder / "plans")], cwd=_ROOT, stdout=subprocess.PIPE, text=True
    ) as desk:
        assert desk.stdout is not None
        try:
            text = ""
            while not text.rstrip().endswith("}"):
                line = desk.stdout.readline()
                if not line:
                    raise JobError("The desk has ended before it served; see above.")
                text += line
            yield json.loads(text)["url"]
        finally:
            desk.send_signal(signal.SIGINT)


def _new_page(browser: Browser) -> Page:
    page = browser.new_context(viewport={"width": _WIDTH, "height": _HEIGHT}).new_page()
    page.set_default_timeout(_LIMIT_MS)
    return page


def _loads_s(browser: Browser, url: str) -> list[float]:
    """Return the seconds until each stage, in a browser with an empty cache."""
    page, seconds = _new_page(browser), []
    begun = time.perf_counter()
    page.goto(url)
    seconds.append(time.perf_counter() - begun)
    for shown in (_MAP, _READY):
        page.wait_for_selector(shown)
        seconds.append(time.perf_counter() - begun)
    page.context.close()
    return seconds


def _generations(page: Page) -> int:
    """Plan; return the generations shown meanwhile."""
    page.get_by_role("button", name="Plan", exact=True).click()
    count = page.locator('[data-role="generation"]')

    def shown() -> int:
        text = (count.text_content() or "").removeprefix("generation ").partition(" ")[0]
        return int(text.replace(",", "") or 0)

    page.wait_for_selector('[data-role="generation"]:has-text("generation")')
    before = shown()
    page.wait_for_timeout(1000 * _SECONDS)
    after = shown()
    page.get_by_role("button", name="Stop", exact=True).click()
    page.wait_for_selector("text=Saved in")
    return after - before
