"""The page of a plan: one HTML file that shows it in any browser, without network access."""

from __future__ import annotations

import base64
import html
import json
import re
from collections.abc import Mapping
from importlib import metadata, resources
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.mission.autopilot.hand_over import USUAL, HandOver
from pathgene.host.web.scene import plan_scene


__all__ = ["MODULES", "page_of", "page_of_scene", "require_library", "three_js"]

#: ES modules of this folder that a page imports.
MODULES = (
    "canvas.js",
    "eye.js",
    "lines.js",
    "map.js",
    "marks.js",
    "profile.js",
    "relief.js",
    "scene.js",
    "solids.js",
    "view.js",
)
# Name under which the modules import three.js, as NiceGUI pages do, and its file in the wheel.
_LIBRARY = "nicegui-scene"
_LIBRARY_FILE = "nicegui/elements/scene/dist/index.js"
_NEEDED = "The page needs three.js of the extra: pip install 'pathgene[desk]' (--write html)."


def page_of(
    evaluator: Evaluator,
    path: NDArray[Any],
    summary: Mapping[str, Any],
    wanted: HandOver = USUAL,
) -> str:
    """Return the page of a plan.

    Parameters
    ----------
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    summary : mapping
        The content of ``summary.json``.
    wanted : HandOver
        The user's choices about the mission that an autopilot gets, which the page shows.

    Raises
    ------
    InputError
        If the extra ``desk``, whose three.js the page contains, is not installed.
    """
    return page_of_scene(plan_scene(evaluator, path, summary, wanted))


def page_of_scene(scene: Mapping[str, Any]) -> str:
    """Return the page of a scene with a path; it raises as :func:`page_of` does."""
    library = three_js()
    imports = {_LIBRARY: library, **{name: _own(name) for name in MODULES}}
    parts = {
        "title": html.escape(scene["title"]),
        "subtitle": html.escape(scene["subtitle"]),
        "style": _text("colours.css") + _text("page.css"),
        # Only "<" can end a script.
        "scene": json.dumps(scene, allow_nan=False).replace("<", "\\u003c"),
        "imports": json.dumps({"imports": {key: _url(text) for key, text in imports.items()}}),
        "program": _own("page.js"),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], _text("page.html"))


def require_library() -> None:
    """Refuse to make a page if the extra ``desk`` is missing; call it before the work.

    Raises
    ------
    InputError
        If it is missing.
    """
    _library_file()


def three_js() -> str:
    """Return three.js and its OrbitControls as one ES module, from the wheel of NiceGUI.

    Raises
    ------
    InputError
        If the extra ``desk`` is not installed.
    """
    return _library_file().read_text(encoding="utf-8")


def _library_file() -> Path:
    # Found through the record of the wheel, because importing NiceGUI takes a second.
    try:
        file = Path(str(metadata.distribution("nicegui").locate_file(_LIBRARY_FILE)))
    except metadata.PackageNotFoundError:
        raise InputError(_NEEDED) from None
    if not file.is_file():
        raise InputError(_NEEDED)
    return file


def _text(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


def _own(name: str) -> str:
    """Return one of our modules; a module in a data URL has no folder, so it imports bare names."""
    return re.sub(r'from "\./(\w+\.js)"', r'from "\1"', _text(name))


def _url(text: str) -> str:
    return "data:text/javascript;base64," + base64.b64encode(text.encode()).decode("ascii")
