"""The page of a tab: its problem, the views, and the plans that it shows."""

from __future__ import annotations

import asyncio
import dataclasses
import operator
from typing import Any

from nicegui import events, ui

from pathgene.host.errors import InputError, PathgeneError
from pathgene.host.evaluation import Evaluator
from pathgene.host.inputs import read_text
from pathgene.host.mission.autopilot.hand_over import hand_over_of
from pathgene.host.mission.build import zones_of
from pathgene.host.mission.drawn import drawn_mission
from pathgene.host.mission.ending import summary_ending
from pathgene.host.numeric import numbers
from pathgene.host.planners import PLANNERS
from pathgene.host.report.read import read_run
from pathgene.host.report.run_files import SUMMARY
from pathgene.host.web.desk.cockpit import Cockpit
from pathgene.host.web.desk.desk import Desk
from pathgene.host.web.desk.drawn import drawn_problem
from pathgene.host.web.desk.files import open_upload
from pathgene.host.web.desk.flight import Goal
from pathgene.host.web.desk.following import Following
from pathgene.host.web.desk.job import FlightJob, PlanJob, SavedJob
from pathgene.host.web.desk.mission_card import MissionCard
from pathgene.host.web.desk.opened import OpenMission
from pathgene.host.web.desk.panels import Panels, panel
from pathgene.host.web.desk.results import EARLIER, PlanView, Results, SavedPlans
from pathgene.host.web.desk.saving import PROBLEM
from pathgene.host.web.desk.sheet import Sheet
from pathgene.host.web.desk.stage import Stage
from pathgene.host.web.scene import mission_scene, path_scene


__all__ = ["Page"]

# Seconds without further changes after which a change is drawn and checked.
_SETTLE_S = 0.15
_LIST_S = 2.0


class Page:
    """The page of a tab.

    Parameters
    ----------
    address : str
        The address of the desk with its token.
    """

    def __init__(self, desk: Desk, address: str) -> None:
        self._desk, self._address = desk, address
        self._sheet = desk.sheet()
        self._drawn_terrain: Any = None
        # Number of the latest drawing of the problem.
        self._settled = 0
        self._build()

    def _build(self) -> None:
        with ui.element("header").classes("top"):
            ui.html("<h1>pathgene desk</h1>", sanitize=False)
            self._terrain = ui.select(
                self._desk.terrains.names,
                label="terrain",
                value=self._sheet.values["terrain"],
                on_change=self._choose_terrain,
            )
            self._planner = ui.select(
                {name: name for name in PLANNERS},
                label="planner",
                value=self._sheet.planner,
                on_change=self._choose_planner,
            )
            for select in (self._terrain, self._planner):
                select.props("dense outlined options-dense stack-label")
            ui.button("Plan", on_click=self.plan).props("unelevated no-caps")
            self._following = Following(self._desk.jobs, self._list)
            ui.space()
            self._upload = ui.upload(on_upload=self._opened, auto_upload=True).classes("hidden")
            for text, act in (
                ("Open ...", lambda: self._upload.run_method("pickFiles")),
                ("Problem file", self._download),
                ("Link", self._show_link),
            ):
                ui.button(text, on_click=act).props("flat dense no-caps")
        self._trouble = ui.label().classes("trouble").props("role=alert")
        with ui.element("div").classes("desk"):
            with ui.element("aside").props('aria-label="Problem"'):
                self._panels = Panels(self._sheet, self._changed, lambda n: self._stage.pick(n))
                with panel("Saved plans"):
                    self._saved = SavedPlans(self._show, self._desk.jobs.stop, self._load)
            self._stage = Stage(self._upload).classes("stage-host")
            with ui.element("section").classes("results").props('data-part="results"'):
                self._cockpit = Cockpit(self._desk.jobs, self._landed)
                self._mission = MissionCard(self._desk, self._sheet, self._settle, self._settle)
                self._results = Results(self._keep, self._drop, self.fly, self._holds)
        self._stage.on("ready", self._ready)
        self._stage.on("drawn", self._drawn)
        self._settling = ui.timer(_SETTLE_S, self._settle, active=False)
        ui.timer(_LIST_S, self._list)
        self._following.show_in(self._stage, self._results)
        self._cockpit.show_in(self._stage)
        self._mission.show_in(self._stage)

    async def _ready(self, event: events.GenericEventArguments) -> None:
        """Load the problem from the address, and draw it."""
        fragment = str(event.args.get("fragment") or "")
        if fragment and await self._tried(self._desk.kept.open_link, self._sheet, fragment):
            self._show_values()
        await self._settle()
        self._list()

    def _holds(self, plan: PlanView) -> bool:
        """Return whether a plan belongs to the current problem."""
        return plan.statement is not None and plan.statement == self._sheet.statement()

    def _leave(self) -> None:
        """Stop showing a flight, a mission or a running plan."""
        self._cockpit.leave()
        self._mission.leave()
        self._following.leave()

    def _changed(self) -> None:
        self._results.check()
        self._mission.changed()
        self._settling.deactivate()
        self._settling.activate()

    async def _settle(self) -> None:
        """Draw the current problem, and say what is wrong with it."""
        self._settling.deactivate()
        self._settled += 1
        number = self._settled
        # The user may change the problem while a thread works on the copy.
        sheet, judged = self._sheet.copy(), None
        try:
            terrain = await asyncio.to_thread(sheet.terrain)
            drawn = await asyncio.to_thread(drawn_problem, sheet, terrain)
            if number != self._settled:
                return  # A later change is being drawn.
            if terrain is not self._drawn_terrain:
                self._drawn_terrain = terrain
                url = await asyncio.to_thread(self._desk.mesh_url, terrain)
                self._leave()
                self._results.show(None, None)
                self._stage.set_terrain(url, drawn)
            else:
                self._stage.set_problem(drawn)
            self._stage.set_link(await asyncio.to_thread(self._link, sheet))
            if self._mission.is_open:
                judged = await asyncio.to_thread(self._mission.judged, sheet)
            else:
                await asyncio.to_thread(sheet.mission)
            sentence = ""
        except PathgeneError as error:
            sentence = str(error)
        if number == self._settled:
            self._say(sentence)
            if self._mission.is_open:
                self._mission.show(judged)

    def _link(self, sheet: Sheet) -> str:
        """Return the fragment for the address of the page; empty if there is no link."""
        try:
            return self._desk.kept.link(sheet)
        except InputError:
            return ""

    def _say(self, sentence: str) -> None:
        self._trouble.text = sentence

    async def _tried(self, function: Any, *values: Any) -> bool:
        """Call a function in a thread; report an error, and return whether it succeeded."""
        try:
            await asyncio.to_thread(function, *values)
        except PathgeneError as error:
            ui.notify(str(error), type="negative", multi_line=True, timeout=0, close_button="Close")
            return False
        return True

    def _show_values(self) -> None:
        """Show all values of another problem."""
        for select, value in (
            (self._terrain, self._sheet.values["terrain"]),
            (self._planner, self._sheet.planner),
        ):
            if select is self._terrain:
                select.set_options(self._desk.terrains.names)
            select.set_value(value)
        self._panels.show()
        self._changed()

    async def _choose_terrain(self, event: events.ValueChangeEventArguments[Any]) -> None:
        if event.value == self._sheet.values["terrain"]:
            return
        if await self._tried(self._sheet.take_terrain, str(event.value)):
            self._results.check()
            self._panels.show()
            await self._settle()
        else:
            self._terrain.set_value(self._sheet.values["terrain"])

    def _choose_planner(self, event: events.ValueChangeEventArguments[Any]) -> None:
        if event.value != self._sheet.planner:
            self._sheet.set("planner", event.value)
            self._panels.show_form()
            self._changed()

    def _drawn(self, event: events.GenericEventArguments) -> None:
        """Handle a drawing of the user on the map."""
        values = event.args
        if self._cockpit.is_open:
            self._happened(values)
            return
        try:
            self._take_drawn(str(values["what"]), values)
        except (KeyError, IndexError, TypeError, ValueError):
            return  # The zone or point no longer exists.
        if values["what"] != "pick":
            self._panels.show_drawn()
            self._changed()

    def _take_drawn(self, what: str, values: Any) -> None:
        sheet = self._sheet
        if what == "pick":
            number = values["number"]
            self._panels.pick(number)
            self._stage.pick(number)
        elif what == "via":
            x, y = numbers([values["x"], values["y"]], 2)
            sheet.add_via(x, y)
        elif what == "place" and values["name"] in ("start", "goal", "via"):
            x, y = numbers([values["x"], values["y"]], 2)
            sheet.place(values["name"], x, y, operator.index(values["number"]))
        elif what == "zone":
            sheet.zones.append(_shape(values))
            number = len(sheet.zones) - 1
            self._panels.pick(number)
            self._stage.pick(number)
        elif what == "reshape":
            sheet.reshape(operator.index(values["number"]), _shape(values))

    def _happened(self, values: Any) -> None:
        """Convert a drawing of the user to an event of the flight."""
        if not self._cockpit.is_flying:
            ui.notify("Close the flight to change the problem.")
            return
        try:
            if values["what"] == "zone":
                table = {"zones": [_shape(values)]}
                (zone,) = zones_of(table, self._drawn_terrain)
                self._cockpit.order(zone)
            elif values["what"] == "place" and values["name"] == "goal":
                self._cockpit.order(Goal(*numbers([values["x"], values["y"]], 2)))
        except InputError as error:
            ui.notify(str(error), type="negative", multi_line=True)
        except (KeyError, TypeError, ValueError):
            return  # The page does not draw anything of this kind.

    async def fly(self) -> None:
        """Fly the displayed plan; the planner of the form plans in flight."""
        plan = self._results.plan
        if plan is None:
            return
        if not self._holds(plan):
            ui.notify(EARLIER, type="negative", multi_line=True)
            return
        try:
            job = await asyncio.to_thread(self._desk.fly, plan.folder, self._sheet)
        except PathgeneError as error:
            ui.notify(str(error), type="negative", multi_line=True)
            return
        self._cockpit.follow(job)
        self._list()

    def _landed(self) -> None:
        # Including the files of the flight.
        self._results.card.refresh()
        self._list()

    async def _show(self, job: SavedJob) -> None:
        """Show a running job."""
        if isinstance(job, FlightJob):
            if await self._load(job.folder.name):
                self._cockpit.follow(job)
        elif isinstance(job, PlanJob):
            self._leave()
            self._following.follow(job)

    async def plan(self) -> None:
        """Plan the problem."""
        try:
            job = await asyncio.to_thread(self._desk.plan, self._sheet)
        except PathgeneError as error:
            self._say(str(error))
            return
        self._leave()
        self._following.follow(job)
        self._list()

    def _list(self) -> None:
        self._saved.show(self._desk.jobs.active, self._desk.saved())

    def _keep(self) -> None:
        plan = self._results.plan
        if plan is not None:
            self._stage.set_kept(plan.to_json())
            self._results.show(plan, plan)

    def _drop(self) -> None:
        self._stage.set_kept(None)
        self._results.show(self._results.plan, None)

    async def _load(self, name: str) -> bool:
        """Show a saved plan with its problem; return whether it could be read."""

        def read() -> tuple[PlanView, str | None]:
            folder = self._desk.directory / name
            planned = read_run(folder / SUMMARY)
            evaluator = Evaluator(planned.problem)
            least_m = planned.summary.get("minimum_clearance_m")
            path = path_scene(evaluator, planned.path, name, least_m=least_m)
            note = self._sheet.open_saved(read_text(folder / PROBLEM))
            if planned.feasible:
                ending = summary_ending(folder / SUMMARY, planned.summary)
                wanted = dataclasses.replace(hand_over_of(self._sheet.values), ending=ending)
                path["mission"] = mission_scene(
                    drawn_mission(planned.problem, evaluator.track(planned.path), wanted)
                )
            statement = self._sheet.statement()
            return PlanView(planned.summary, path, folder, "saved", statement), note

        try:
            view, note = await asyncio.to_thread(read)
        except (PathgeneError, OSError, ValueError) as error:
            ui.notify(str(error), type="negative", multi_line=True)
            return False
        if note is not None:
            ui.notify(note, multi_line=True)
        self._leave()
        self._show_values()
        await self._settle()
        self._stage.begin()
        self._stage.set_plan(view.to_json())
        self._results.show(view, self._results.kept)
        return True

    async def _opened(self, event: events.UploadEventArguments) -> None:
        """Open a file from the user: a problem, zones, a mission, an aircraft or a terrain."""
        content = await event.file.read()
        self._upload.reset()
        said: list[str] = []
        missions: list[OpenMission] = []

        def open_it() -> None:
            sentences, mission = open_upload(
                self._sheet, self._desk.terrains, event.file.name, content, self._mission.opened
            )
            said.extend(sentences)
            missions.extend([] if mission is None else [mission])

        if await self._tried(open_it):
            for mission in missions:
                self._leave()
                self._mission.open(mission, said)
            self._show_values()
            if said and not missions:
                ui.notify(" ".join(said), multi_line=True, timeout=0, close_button="Close")

    def _download(self) -> None:
        ui.download.content(self._sheet.text(), "problem.toml", "application/toml")

    async def _show_link(self) -> None:
        try:
            fragment = await asyncio.to_thread(self._desk.kept.link, self._sheet.copy())
        except InputError as error:
            ui.notify(str(error), type="negative", multi_line=True)
            return
        link = f"{self._address}#{fragment}"
        with ui.dialog(value=True) as dialog, ui.card():
            ui.label(
                "The problem is too large for a link. The desk keeps it, and this link opens it."
                if fragment.startswith("kept=")
                else "This link holds the whole problem. It opens on this desk while it runs."
            )
            field = ui.input("link", value=link).props("readonly outlined dense").classes("link")
            with ui.row():
                ui.button("Copy", on_click=lambda: _copy(field.value or "")).props("no-caps")
                ui.button("Close", on_click=dialog.close).props("flat no-caps")


def _copy(text: str) -> None:
    ui.clipboard.write(text)
    ui.notify("Copied.")


def _shape(values: Any) -> dict[str, Any]:
    """Return the shape of a zone from a browser, rounded to the decimetre."""
    if "circle" in values:
        x, y, radius_m = numbers(values["circle"], 3)
        return {"circle": (round(x, 1), round(y, 1), round(radius_m, 1))}

    def ring(corners: Any) -> list[list[float]]:
        return [[round(part, 1) for part in numbers(corner, 2)] for corner in corners]

    shape: dict[str, Any] = {"polygon": ring(values["polygon"])}
    if values.get("holes"):
        shape["holes"] = [ring(hole) for hole in values["holes"]]
    return shape
