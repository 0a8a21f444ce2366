"""Contents and requests of a page."""

import io
import re
from urllib.parse import urlsplit

import numpy as np
from matplotlib.image import imread


LOCAL_HOSTS = {"localhost", "127.0.0.1", "::1"}
LOCAL_SCHEMES = {"file", "data", "blob", "about"}
#: WebSockets that leave this machine. Playwright only ignores local ones if a pattern is given.
AFAR = re.compile(r"wss?://(?!(localhost|127\.0\.0\.1|\[::1\])[:/])")


def is_local(url):
    """Return whether a request stays on this machine."""
    parts = urlsplit(url)
    return parts.scheme in LOCAL_SCHEMES or parts.hostname in LOCAL_HOSTS


def pixels(locator):
    """Pixels of an element: (height, width, 3) float, 0 to 1."""
    return imread(io.BytesIO(locator.screenshot()))[..., :3]


def colours(image):
    """Number of distinct colours of an image, in steps of 16."""
    coarse = (image * 15).round().astype(int) @ np.array([256, 16, 1])
    return len(np.unique(coarse))


def settle(page):
    """Wait for two frames, after which every request to draw is done."""
    page.evaluate(
        """() => new Promise((done) => {
          requestAnimationFrame(() => requestAnimationFrame(done));
        })"""
    )
