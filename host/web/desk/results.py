"""The figures of a plan next to a kept plan's, its files, and the saved plans."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from nicegui import ui

from pathgene.host.formats.registry import FORMATS
from pathgene.host.mission.legs import shortcoming
from pathgene.host.report.reading import warnings_in
from pathgene.host.report.routes import route_from, route_note
from pathgene.host.web.desk.job import FlightJob, SavedJob, State
from pathgene.host.web.figures import figures


__all__ = ["EARLIER", "PlanView", "Results", "rows_of"]

# Maximum number of saved plans that the panel lists.
_LISTED = 30
# Names of the files that a user may download.
_FILES = {
    **{row.file: row.button for row in FORMATS if row.button},
    "problem.toml": "Problem",
    "flight.png": "Flight",
    "flight.gif": "Flight, moving",
}


#: Sentence about a plan whose problem has changed.
EARLIER = "This plan is of an earlier problem. Plan again to fly a plan or to take its files."


@dataclass(frozen=True, eq=False)
class PlanView:
    """A finished plan on a page.

    Parameters
    ----------
    summary : dict
        Content of its ``summary.json``.
    state : str
        State of its job. Its files are in the folder once the state is ``saved``.
    statement : str, optional
        Its problem in the form of :meth:`pathgene.host.web.desk.sheet.Sheet.statement`.
    """

    summary: dict[str, Any]
    path: dict[str, Any]
    folder: Path
    state: State
    statement: str | None = None

    def to_json(self) -> dict[str, Any]:
        """The plan in the form that ``stage.js`` expects."""
        return {"path": self.path, "rows": self.summary["history"]}


def rows_of(
    plans: Sequence[PlanView], earlier: Collection[PlanView] = ()
) -> list[tuple[str, list[str]]]:
    """Return the table of plans, one row per figure: its label, and its text for each plan.

    Parameters
    ----------
    earlier : collection of PlanView
        The plans of an earlier problem; their verdict says so.
    """
    columns = [_column(plan.summary, is_earlier=plan in earlier) for plan in plans]
    labels = list(dict.fromkeys(label for column in columns for label in column))
    return [(label, [column.get(label, "–") for column in columns]) for label in labels]


def _column(summary: Mapping[str, Any], *, is_earlier: bool) -> dict[str, str]:
    verdict = "✓ feasible" if summary["feasible"] else "✗ not feasible"
    if is_earlier:
        verdict = f"{verdict[2:]} in an earlier problem"
    by = summary["planner"]
    if summary.get("fallback"):
        by += f", then {summary['fallback']}"
    if note := route_note(route_from(summary)):
        by += f", {note}"
    column = {"Planner": by, "Verdict": verdict}
    if warnings := warnings_in(summary):
        column["Warnings"] = " ".join(warnings)
    column |= {figure["label"]: figure["text"] for figure in figures(summary)}
    column["Time here"] = f"{summary['seconds']['total']:.2f} s"
    plan_us = (summary.get("hardware") or {}).get("plan_us")
    if plan_us is not None:
        column["Time of the chip"] = f"{plan_us / 1000:,.1f} ms"
    return column


class Results:
    """The card of the finished plans.

    Parameters
    ----------
    keep, drop, fly : callable
        Called when the user keeps the plan, drops the kept one, or flies the plan.
    holds : callable
        Returns whether a plan belongs to the current problem. Only such a plan can be flown or
        downloaded.
    """

    def __init__(
        self,
        keep: Callable[[], object],
        drop: Callable[[], object],
        fly: Callable[[], object],
        holds: Callable[[PlanView], bool],
    ) -> None:
        self.plan: PlanView | None = None
        self.kept: PlanView | None = None
        self._keep, self._drop, self._fly, self._holds = keep, drop, fly, holds
        self._earlier: list[PlanView] = []
        with ui.element("header"):
            ui.html("<h2>Plan</h2>", sanitize=False)
            # They stay while the card is built again, as a click on a removed button would be lost.
            with ui.row().classes("actions"):
                self._flies = ui.button("Fly", on_click=self._fly)
                self._flies.props("unelevated dense no-caps")
                with self._flies:
                    self._reason = ui.tooltip()
                self._keeps = ui.button("Keep to compare", on_click=self._keep)
                self._keeps.props("flat dense no-caps")
                self._drops = ui.button("Drop kept", on_click=self._drop)
                self._drops.props("flat dense no-caps")
        self.card()

    def check(self) -> None:
        """After a change of the problem, show which of the plans still belong to it."""
        if self._earlier != self._not_held():
            self.card.refresh()

    def _not_held(self) -> list[PlanView]:
        return [
            plan for plan in (self.plan, self.kept) if plan is not None and not self._holds(plan)
        ]

    def show(self, plan: PlanView | None, kept: PlanView | None) -> None:
        """Show other plans."""
        self.plan, self.kept = plan, kept
        self.card.refresh()

    @ui.refreshable_method
    def card(self) -> None:
        """Build the elements of the card."""
        self._earlier = self._not_held()
        is_earlier = self.plan in self._earlier
        self._offer(is_earlier)
        plans = [plan for plan in (self.plan, self.kept) if plan is not None]
        if not plans:
            ui.label("The figures of a plan appear here.").classes("empty")
            return
        with ui.element("div").classes("scroll"):
            if self.plan is not None and (reason := shortcoming(self.plan.summary)):
                ui.label(reason).classes("reason")
            if is_earlier:
                ui.label(EARLIER).classes("reason").props("role=status")
            elif self.plan is not None:
                _files(self.plan)
            self._table(plans)

    def _offer(self, is_earlier: bool) -> None:
        """Show the buttons that the plans have."""
        self._flies.set_visibility(self.plan is not None and self.plan.state == "saved")
        reason = ""
        if is_earlier:
            reason = EARLIER
        elif self.plan is not None and (
            self.plan.summary.get("via") or self.plan.summary.get("as_paper")
        ):
            reason = "Plans with via points, and as paper, are not flown."
        self._flies.set_enabled(not reason)
        self._reason.text = reason
        self._reason.set_visibility(bool(reason))
        self._keeps.set_visibility(self.plan is not None)
        self._drops.set_visibility(self.kept is not None)

    def _table(self, plans: Sequence[PlanView]) -> None:
        with ui.element("table").classes("figures"):
            if self.kept is not None:
                with ui.element("thead"), ui.element("tr"):
                    _cell("th", "")
                    if self.plan is not None:
                        _cell("th", "This plan").classes("this")
                    _cell("th", "Kept").classes("kept")
            with ui.element("tbody"):
                for label, texts in rows_of(plans, self._earlier):
                    with ui.element("tr"):
                        _cell("th", label).props("scope=row")
                        for text in texts:
                            _cell("td", text)


def _cell(tag: str, text: str) -> ui.element:
    with ui.element(tag) as cell:
        ui.label(text).classes("word")
    return cell


def _files(plan: PlanView) -> None:
    """Add links to the existing files of a saved plan."""
    with ui.row().classes("files"):
        if plan.state != "saved":
            ui.label("Not saved." if plan.state == "failed" else "Saving ...")
            return
        ui.label("Files:")
        for name, text in _FILES.items():
            if not (plan.folder / name).is_file():
                continue
            with ui.element("a").props(
                f'href="/plans/{quote(plan.folder.name)}/{name}" download="{name}"'
            ):
                ui.label(text).classes("word")


class SavedPlans:
    """The panel of running jobs and saved plans.

    Parameters
    ----------
    follow, stop, load : callable
        Called with the job, or with the name of the plan, that the user chooses.
    """

    def __init__(
        self,
        follow: Callable[[SavedJob], object],
        stop: Callable[[SavedJob], object],
        load: Callable[[str], object],
    ) -> None:
        self._follow, self._stop, self._load = follow, stop, load
        self._jobs: list[SavedJob] = []
        self._names: list[str] = []
        self.entries()

    def show(self, jobs: list[SavedJob], names: list[str]) -> None:
        """Show jobs and plans, if they have changed."""
        names = names[:_LISTED]
        if (jobs, names) != (self._jobs, self._names):
            self._jobs, self._names = jobs, names
            self.entries.refresh()

    @ui.refreshable_method
    def entries(self) -> None:
        """Build the entries."""
        for job in self._jobs:
            with ui.row().classes("zone-head"):
                does = "flies" if isinstance(job, FlightJob) else "runs"
                ui.button(
                    f"{job.folder.name} ({does})", on_click=lambda job=job: self._follow(job)
                ).props("flat dense no-caps align=left").classes("grow")
                ui.button("Stop", on_click=lambda job=job: self._stop(job)).props(
                    "flat dense no-caps"
                )
        for name in self._names:
            ui.button(name, on_click=lambda name=name: self._load(name)).props(
                "flat dense no-caps align=left"
            ).classes("grow")
        if not self._jobs and not self._names:
            ui.label("None yet.").classes("empty")
