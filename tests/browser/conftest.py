"""Chromium for the tests of pages, behind a guard: a page that asks any network for anything fails.

The desk's tests use the same fixtures; they serve their pages on this machine.
"""

import io
import os
import shutil
from urllib.parse import urlsplit

import numpy as np
import pytest
from matplotlib.image import imread


# WebGL is drawn by the processor: the same on every machine, with or without a graphics card.
OPTIONS = ("--enable-unsafe-swiftshader", "--use-angle=swiftshader")
LOCAL_HOSTS = {"localhost", "127.0.0.1", "::1"}
LOCAL_SCHEMES = {"file", "data", "blob", "about"}


def is_local(url):
    """Return whether a request stays on this machine."""
    parts = urlsplit(url)
    return parts.scheme in LOCAL_SCHEMES or parts.hostname in LOCAL_HOSTS


def pixels(locator):
    """What an element shows: (height, width, 3) float, 0 to 1."""
    return imread(io.BytesIO(locator.screenshot()))[..., :3]


def colours(image):
    """Number of different colours of an image, told apart in steps of 16."""
    coarse = (image * 15).round().astype(int) @ np.array([256, 16, 1])
    return len(np.unique(coarse))


def settle(page):
    """Wait until what was asked to be drawn is drawn: two frames."""
    page.evaluate(
        """() => new Promise((done) => {
          requestAnimationFrame(() => requestAnimationFrame(done));
        })"""
    )


@pytest.fixture(scope="module")
def browser():
    """Chromium, without a window.

    It ends with its module: its event loop, which runs until then, would be in the way of others.
    """
    program = shutil.which("chromium")
    if program is None:
        pytest.skip("Chromium is not installed (Debian package chromium)")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        # Root, as in a container, has no sandbox.
        options = [*OPTIONS, *(["--no-sandbox"] if os.geteuid() == 0 else [])]
        chromium = playwright.chromium.launch(executable_path=program, args=options)
        yield chromium
        chromium.close()


@pytest.fixture
def new_page(browser):
    """Function (width, height, **options) that opens a page; options are those of a context.

    After the test it fails for each request to a network and each error on a page: for what
    ``new_page.faults`` then holds.
    """
    contexts, faults = [], []

    def open_page(width=1280, height=720, **options):
        context = browser.new_context(viewport={"width": width, "height": height}, **options)
        contexts.append(context)

        def guard(route):
            url = route.request.url
            if is_local(url):
                route.continue_()
            else:
                faults.append(f"a request to {url}")
                route.abort()

        context.route("**/*", guard)
        page = context.new_page()
        page.on("pageerror", lambda error: faults.append(f"an error: {error}"))
        page.on(
            "console",
            lambda message: message.type == "error" and faults.append(f"the error {message.text}"),
        )
        return page

    open_page.faults = faults
    yield open_page
    for context in contexts:
        context.close()
    assert faults == []
