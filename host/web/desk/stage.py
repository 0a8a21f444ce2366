"""The views of the desk as a NiceGUI element; ``stage.js`` draws them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import nicegui
from nicegui.element import Element


__all__ = ["Stage"]

_LIBRARY = Path(nicegui.__file__).parent / "elements" / "scene" / "dist"
_VIEWS = Path(__file__).resolve().parents[1]


class Stage(
    Element,
    component="stage.js",
    esm={"nicegui-scene": str(_LIBRARY), "pathgene-views": str(_VIEWS)},
):
    """3-D view, map with tools, profile and fitness.

    Events: ``ready`` with the ``fragment`` of the address; ``drawn`` with ``what`` and the values
    of ``tools.js``.

    Parameters
    ----------
    uploader : Element
        The upload that gets files which a user drops on the page.
    """

    def __init__(self, uploader: Element) -> None:
        super().__init__()
        self._props["uploader"] = uploader.id

    def set_terrain(self, url: str, problem: Mapping[str, Any]) -> None:
        """Show another terrain: the result of ``terrain_scene`` at ``url``."""
        self.run_method("setTerrain", url, problem)

    def set_problem(self, problem: Mapping[str, Any]) -> None:
        """Show ``points``, ``zones`` and ``ceilings`` of a problem as in a scene."""
        self.run_method("setProblem", problem)

    def begin(self) -> None:
        """Begin to show the generations of a plan."""
        self.run_method("begin")

    def progress(self, rows: list[list[Any]]) -> None:
        """Show generations: number, best and mean fitness, and a better path or None."""
        self.run_method("progress", rows)

    def set_plan(self, plan: Mapping[str, Any] | None) -> None:
        """Show a finished plan: ``path`` as in a scene, and ``rows`` of its generations."""
        self.run_method("setPlan", plan)

    def set_kept(self, plan: Mapping[str, Any] | None) -> None:
        """Show a second plan alongside the plan."""
        self.run_method("setKept", plan)

    def fly(self) -> None:
        """Begin to show a flight; the tools draw its events."""
        self.run_method("fly")

    def flown(self, news: Mapping[str, Any]) -> None:
        """Show the news of the flight: see ``flight.js``."""
        self.run_method("flown", news)

    def land(self) -> None:
        """Stop showing the flight."""
        self.run_method("land")

    def set_mission(self, mission: Mapping[str, Any] | None) -> None:
        """Show a judged mission instead of the problem's points and plans; None shows these again.

        Parameters
        ----------
        mission : mapping or None
            ``name``; ``path`` and ``kept`` as in a scene, or None; ``points`` and ``faults`` as in
            a scene.
        """
        self.run_method("setMission", mission)

    def mark_at(self, at_m: float) -> None:
        """Mark the place of the shown track at a number of metres flown."""
        self.run_method("markAt", at_m)

    def pick(self, number: int | None) -> None:
        """Show the handles of a zone."""
        self.run_method("pick", number)

    def set_link(self, fragment: str) -> None:
        """Put the problem into the address of the page."""
        self.run_method("setLink", fragment)
