"""Chromium for the tests of pages, guarded so that any network request of a page fails the test.

The desk's tests use the same fixtures; they serve their pages on this machine.
"""

import os
import shutil

import pytest

from tests.browser.desk_page import PATIENCE_MS, ready, serving
from tests.browser.seen import AFAR, is_local


# WebGL is rendered by the processor, identically on every machine, with or without a graphics card.
# The rest of a page would be, too, which takes 1.7 times the processor.
OPTIONS = ("--enable-unsafe-swiftshader", "--use-angle=swiftshader", "--disable-gpu-rasterization")


@pytest.fixture(scope="module")
def browser():
    """Chromium, without a window.

    It ends with its module, because its event loop would disturb later modules.
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
    """Function (width, height, **options of a browser context) that opens a page.

    After the test, it fails for each network request and each error on a page; they are in
    ``new_page.faults``.
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
        # This route connects to nothing.
        context.route_web_socket(AFAR, lambda socket: faults.append(f"a WebSocket to {socket.url}"))
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


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    """Address of a desk, and the folder of its plans."""
    folder = tmp_path_factory.mktemp("desk")
    with serving(folder) as (url, _):
        yield url, folder


@pytest.fixture
def open_desk(desk, new_page):
    """Function that opens the desk in a new browser, at a fragment if one is given.

    Motion is reduced, as a user may ask for, because each frame is drawn by the processor.
    """

    def opened(fragment="", width=1280, height=720, **options):
        page = new_page(width, height, **{"reduced_motion": "reduce", **options})
        page.set_default_timeout(PATIENCE_MS)
        page.goto(desk[0] + fragment)
        ready(page)
        return page

    return opened
