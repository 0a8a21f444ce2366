"""The card of an open mission: its verdict, its faults, and the mended mission next to it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from typing import Any

from nicegui import ui

from pathgene.host.errors import InputError, PathgeneError
from pathgene.host.formats.registry import mission_in
from pathgene.host.mission.foreign.words import counted
from pathgene.host.web.desk.desk import Desk
from pathgene.host.web.desk.job import MendJob
from pathgene.host.web.desk.opened import Judged, OpenMission
from pathgene.host.web.desk.sheet import Sheet
from pathgene.host.web.desk.stage import Stage


__all__ = ["MissionCard"]

# Polling period of a job, seconds.
_POLL_S = 0.1
# Faults or changes in the list: NiceGUI takes a second to make the buttons of some hundreds.
_LISTED = 100
_NOTHING: dict[str, Any] = {"path": None, "kept": None, "points": [], "faults": []}


class MissionCard:
    """The mission that a page shows, if any. Its elements are added where it is constructed.

    Parameters
    ----------
    sheet : Sheet
        The problem of the page, by whose terrain, zones, aircraft and rules a mission is judged.
    judge : callable
        Has the page judge the mission: it calls :meth:`judged` and then :meth:`show`.
    closed : callable
        Called when the user closes the mission.
    """

    def __init__(
        self,
        desk: Desk,
        sheet: Sheet,
        judge: Callable[[], Awaitable[None]],
        closed: Callable[[], Awaitable[None]],
    ) -> None:
        self._desk, self._sheet, self._judge, self._closed = desk, sheet, judge, closed
        self._stage: Stage | None = None
        # As the user gave it, and then mended.
        self._missions: list[OpenMission] = []
        self._verdicts: list[Judged] = []
        # The verdicts are of the current problem; None: there are none.
        self._is_current: bool | None = False
        self._front = 0
        self._job: MendJob | None = None
        self._trouble = ""
        self._said: tuple[str, ...] = ()
        self._timer = ui.timer(_POLL_S, self._look, active=False)
        with ui.element("div").classes("takeover mission") as self._root:
            self.card()
        self._root.set_visibility(False)
        ui.context.client.on_delete(self._stop)

    def show_in(self, stage: Stage) -> None:
        """Set the views in which the mission is shown."""
        self._stage = stage

    @property
    def is_open(self) -> bool:
        """True while the page shows a mission."""
        return bool(self._missions)

    @property
    def opened(self) -> OpenMission | None:
        """The mission as the user gave it."""
        return self._missions[0] if self._missions else None

    def open(self, mission: OpenMission, said: Sequence[str] = ()) -> None:
        """Show another mission once it is judged, with the report on its file in sentences."""
        self._stop()
        self._said = tuple(said)
        self._missions, self._verdicts, self._front = [mission], [], 0
        self._trouble, self._is_current = "", False
        self._root.set_visibility(True)
        self.card.refresh()

    def leave(self) -> None:
        """Stop showing a mission."""
        if not self._missions:
            return
        self._stop()
        self._missions, self._verdicts = [], []
        self._root.set_visibility(False)
        if self._stage is not None:
            self._stage.set_mission(None)

    def changed(self) -> None:
        """After a change of the problem, offer nothing until the mission is judged again."""
        if self._missions and self._is_current is not False:
            self._is_current, self._trouble = False, ""
            self.card.refresh()

    def judged(self, sheet: Sheet) -> tuple[list[OpenMission], list[Judged]]:
        """Judge the mission, and the mended one, by a problem.

        Raises
        ------
        InputError
            If the problem is bad, or a mission cannot be judged.
        """
        missions = list(self._missions)
        problem = sheet.flight_problem()
        return missions, [each.judged(problem) for each in missions]

    def show(self, judged: tuple[list[OpenMission], list[Judged]] | None) -> None:
        """Show a result of :meth:`judged`; None if the mission cannot be judged."""
        if judged is not None:
            missions, self._verdicts = judged
            if missions != self._missions:
                return  # Another mission is being judged.
        self._is_current = None if judged is None else True
        self._draw()
        self.card.refresh()

    def _draw(self) -> None:
        """Show the mission in the views, with its counterpart as a kept plan."""
        if self._stage is None or self.opened is None:
            return
        scenes = [each.scene for each in self._verdicts]
        shown = dict(_NOTHING)
        if scenes:
            front = scenes[self._front]
            paths = [scene["paths"][0] if scene["paths"] else None for scene in scenes]
            path = paths[self._front]
            shown = {"path": path, "points": front["points"], "faults": front["faults"]}
            shown["kept"] = paths[1 - self._front] if len(paths) > 1 else None
            if not self._is_current:
                shown["faults"] = []
                if path is not None:
                    shown["path"] = {**path, "track": {**path["track"], "broken": []}}
        self._stage.set_mission({**shown, "name": self.opened.name})

    async def mend(self) -> None:
        """Start to mend the mission."""
        mission = self.opened
        if mission is None or self._job is not None:
            return
        try:
            self._job = await asyncio.to_thread(self._desk.mend, mission, self._sheet)
        except PathgeneError as error:
            self._trouble = str(error)
        else:
            self._trouble = ""
            self._timer.activate()
        self.card.refresh()

    def _stop(self) -> None:
        """End the mending; the mission stays as it is."""
        self._timer.deactivate()
        if self._job is not None:
            self._desk.jobs.stop(self._job)
        self._job = None

    def stop(self) -> None:
        """End the mending, and say so."""
        if self._job is not None:
            self._desk.jobs.stop(self._job)

    async def _look(self) -> None:
        """Take the mended mission once it is there."""
        job = self._job
        if job is None or not job.done:
            return
        self._timer.deactivate()
        self._job = None
        if job.result is None:
            self._trouble = job.error or ""
            self.card.refresh()
            return
        name, content = job.result.name, job.result.content
        mission = mission_in(content, name)
        if mission is None:
            raise InputError(f"{name}: there is no mission in it.")
        del self._missions[1:]
        self._missions.append(OpenMission(name, content, mission, said=job.result.said))
        self._verdicts, self._front, self._is_current = [], 1, False
        await self._judge()

    def _turn(self) -> None:
        """Exchange the opened and the mended mission."""
        self._front = 1 - self._front
        self._draw()
        self.card.refresh()

    async def _close(self) -> None:
        self.leave()
        await self._closed()

    def _mark(self, at_m: float) -> Callable[[], None]:
        def mark() -> None:
            if self._stage is not None:
                self._stage.mark_at(at_m)

        return mark

    @ui.refreshable_method
    def card(self) -> None:
        """Build the elements of the card."""
        if not self._missions:
            return
        with ui.element("header"):
            ui.html("<h2>Mission</h2>", sanitize=False)
            with ui.row().classes("actions"):
                self._actions()
                ui.button("Close mission", on_click=self._close).props("flat dense no-caps")
        mission = self._missions[self._front]
        if not self._is_current:
            text = (
                "is not judged; see above." if self._is_current is None else "is being judged ..."
            )
            ui.label(f"{mission.name} {text}").classes("latest").props("role=status")
            return
        judged = self._verdicts[self._front]
        faults = judged.scene["faults"]
        verdict = f"✗ {counted(len(faults), 'fault')}" if faults else "✓ no fault"
        with ui.element("div").classes("scroll"):
            if self._trouble:
                ui.label(self._trouble).classes("reason").props("role=alert")
            label = ui.label(f"{verdict} · {mission.name}").props("role=status")
            label.classes("latest" if not faults else "reason")
            self._lists(mission, judged)
            self._table()

    def _actions(self) -> None:
        if self._job is not None:
            ui.label("Mending ...").classes("status").props("role=status")
            ui.button("Stop mending", on_click=self.stop).props("outline dense no-caps")
            return
        if not self._is_current:
            return
        is_mended = len(self._missions) > 1
        if not self._verdicts[-1].check.feasible:
            ui.button("Mend", on_click=self.mend).props("unelevated dense no-caps")
        elif is_mended:
            mended = self._missions[1]
            ui.button(
                f"Download {mended.name}",
                on_click=lambda: ui.download.content(mended.source, mended.name),
            ).props("unelevated dense no-caps")
        if is_mended:
            text = "Show as opened" if self._front else "Show mended"
            ui.button(text, on_click=self._turn).props("outline dense no-caps")

    def _lists(self, mission: OpenMission, judged: Judged) -> None:
        """Add the faults, the changes, and the remarks on the file."""
        faults = judged.scene["faults"]
        with ui.element("ol").props('aria-label="Faults"').classes("faults"):
            for fault in faults[:_LISTED]:
                with ui.element("li"):
                    button = ui.button(fault["sentence"]).props("flat dense no-caps align=left")
                    button.classes("grow")
                    if fault["at_m"] is None:
                        button.disable()
                    else:
                        button.on_click(self._mark(fault["at_m"]))
        _more(faults)
        if mission.said:
            with ui.element("ul").props('aria-label="Changes"').classes("said"):
                for sentence in mission.said[:_LISTED]:
                    _item(sentence)
            _more(mission.said)
        else:
            remarks = judged.check.reading.remarks
            with ui.element("ul").props('aria-label="Remarks"').classes("said muted"):
                for sentence in self._said:
                    _item(sentence)
                for remark in remarks:
                    _item(f"{remark.grade.capitalize()}: {remark.text}")

    def _table(self) -> None:
        """Add the figures of the opened and the mended mission."""
        columns = [dict(each.check.pairs[1:]) for each in self._verdicts]
        with ui.element("table").classes("figures"):
            if len(columns) > 1:
                with ui.element("thead"), ui.element("tr"):
                    _cell("th", "")
                    for number, text in enumerate(("As opened", "Mended")):
                        _cell("th", text).classes("this" if number == self._front else "kept")
            with ui.element("tbody"):
                for name in columns[0]:
                    with ui.element("tr"):
                        _cell("th", name.capitalize()).props("scope=row")
                        for column in columns:
                            _cell("td", column[name])


def _more(listed: Sequence[object]) -> None:
    if len(listed) > _LISTED:
        ui.label(f"and {len(listed) - _LISTED:,} more").classes("word")


def _item(sentence: str) -> None:
    with ui.element("li"):
        ui.label(sentence).classes("word")


def _cell(tag: str, text: str) -> ui.element:
    with ui.element(tag) as cell:
        ui.label(text).classes("word")
    return cell
