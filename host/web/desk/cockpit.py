"""A page that shows a flight: the aircraft in the views, events and decisions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from nicegui import ui

from pathgene.host.web.desk.flight import AHEAD, CLEAR, FASTEST, USUAL, Flown, Goal, Speed
from pathgene.host.web.desk.job import NEWS, FlightJob
from pathgene.host.web.desk.jobs import Jobs
from pathgene.host.web.desk.stage import Stage


__all__ = ["Cockpit"]

_POLL_S = 0.05
# Speeds to choose from; 0 stops the time.
_SPEEDS = {0.0: "stands still", 1.0: "1 ×", USUAL: "4 ×", 16.0: "16 ×", FASTEST: "64 ×"}
# Number of sentences shown, latest first.
_SENTENCES = 40
_END, _CLOSE = "End flight", "Close flight"
_DOES = {"path": "on its path", "holding": "on a safe circle", "way-out": "on a way out"}


class Cockpit:
    """The flight that a page shows, if any. Its elements are added where it is constructed."""

    def __init__(self, jobs: Jobs, ended: Callable[[], object]) -> None:
        self._jobs, self._ended = jobs, ended
        self._stage: Stage | None = None
        self._job: FlightJob | None = None
        # Number of entries of the job's lists, and numbers of its news, that the page has received.
        self._trail = self._versions = self._said = 0
        self._known = dict.fromkeys(NEWS, 0)
        self._shown: Flown | None = None
        self._timer = ui.timer(_POLL_S, self._look, active=False)
        self._build()
        ui.context.client.on_delete(self._gone)

    def _build(self) -> None:
        with ui.element("div").classes("takeover cockpit") as self._root:
            with ui.element("header"):
                ui.html("<h2>Flight</h2>", sanitize=False)
                self._end = ui.button(_END, on_click=self.end).props("flat dense no-caps")
            self._state = ui.label().classes("readout").props('data-role="flying"')
            with ui.row().classes("actions"):
                self._speed = ui.select(
                    _SPEEDS, label="speed", value=USUAL, on_change=self._set_speed
                ).props("dense outlined options-dense stack-label")
                acts = {
                    "Zone ahead": lambda: self.order(AHEAD),
                    "Zones away": lambda: self.order(CLEAR),
                }
                buttons = [ui.button(text, on_click=act) for text, act in acts.items()]
            self._latest = ui.label().classes("latest").props('role=status data-role="replan"')
            with ui.row().classes("actions goal"):
                self._goal = [
                    ui.number(name).props(
                        f'dense outlined stack-label aria-label="New goal, {name}"'
                    )
                    for name in ("east m", "north m")
                ]
                buttons.append(ui.button("New goal", on_click=self._set_goal))
            for button in buttons:
                button.props("outline dense no-caps")
            self._offered: Sequence[Any] = (self._speed, *self._goal, *buttons)
            self._log = ui.element("ol").classes("log")
            self._log.props('role=log aria-label="Events of the flight"')
        self._root.set_visibility(False)

    def show_in(self, stage: Stage) -> None:
        """Set the views in which the aircraft is shown."""
        self._stage = stage

    @property
    def is_open(self) -> bool:
        """True while the page shows a flight, or the end of one."""
        return self._job is not None

    @property
    def is_flying(self) -> bool:
        """True while the flight that this page shows is in progress."""
        return self._job is not None and self._job.state == "flying"

    def follow(self, job: FlightJob) -> None:
        """Show a flight from its beginning."""
        assert self._stage is not None
        self.leave()
        self._job = job
        self._trail = self._versions = self._said = 0
        self._known = dict.fromkeys(NEWS, 0)
        self._shown = None
        self._latest.text = self._state.text = ""
        self._log.clear()
        if not job.watchers:
            self.order(Speed(USUAL))
        job.watchers.add(self)
        self._root.set_visibility(True)
        self._stage.fly()
        self._timer.activate()
        self._look()
        ui.run_javascript(f"getHtmlElement({self._end.id})?.focus()")

    def leave(self) -> None:
        """Stop showing a flight; a flight that no page shows continues at maximum speed."""
        if self._job is None:
            return
        if self.is_flying:
            ui.notify("The flight continues; Saved plans shows it.")
        self._gone()
        self._timer.deactivate()
        self._root.set_visibility(False)
        if self._stage is not None:
            self._stage.land()

    def _gone(self) -> None:
        """Note that this page no longer shows its flight."""
        job = self._job
        if job is not None:
            job.watchers.discard(self)
            if not job.watchers:
                self.order(Speed(FASTEST))
        self._job = None

    def order(self, order: object) -> None:
        """Send an event to the flight: see :mod:`pathgene.host.web.desk.flight`."""
        if self._job is None:
            return
        if isinstance(order, Speed):
            self._job.speed = order.factor
        self._jobs.tell(self._job, order)

    def end(self) -> None:
        """End the flight; if it has already ended, stop showing it."""
        if self._job is not None and self.is_flying:
            self._jobs.stop(self._job)
        else:
            self.leave()

    def _set_speed(self) -> None:
        if self._job is not None and self._speed.value != self._job.speed:
            self.order(Speed(float(self._speed.value)))

    def _set_goal(self) -> None:
        x, y = (field.value for field in self._goal)
        if x is not None and y is not None:
            self.order(Goal(float(x), float(y)))

    def _look(self) -> None:
        """Show the news of the flight since the previous call."""
        job = self._job
        if job is None:
            return
        is_done = job.done
        flown = job.latest
        news = self._news(job)
        if flown is not None and (news or flown is not self._shown):
            self._shown = flown
            trail, versions = job.trail[self._trail :], job.versions[self._versions :]
            self._trail += len(trail)
            self._versions += len(versions)
            assert self._stage is not None
            self._stage.flown(
                {
                    "aircraft": flown.aircraft,
                    "trail": trail,
                    "versions": versions,
                    **{name: news.get(name) for name in ("zones", "points", "path")},
                }
            )
        for sentence in job.said[self._said :]:
            self._said += 1
            self._add(sentence)
        if "changes" in news:
            self._latest.text = _words(news["changes"])
        self._show_state(job, flown)
        if is_done:
            self._timer.deactivate()
            self._ended()

    def _news(self, job: FlightJob) -> dict[str, Any]:
        """Return the news that the page does not have yet."""
        found = {}
        for name, (number, value) in job.news.copy().items():
            if number > self._known[name]:
                self._known[name] = number
                found[name] = value
        return found

    def _add(self, sentence: str) -> None:
        with self._log:
            with ui.element("li") as item:
                ui.label(sentence).classes("word")
            item.move(target_index=0)
        for old in self._log.default_slot.children[_SENTENCES:]:
            old.delete()

    def _show_state(self, job: FlightJob, flown: Flown | None) -> None:
        """Show the state of the aircraft, and enable the controls that have an effect."""
        for element in self._offered:
            element.set_enabled(self.is_flying and flown is not None)
        self._end.set_text(_END if self.is_flying else _CLOSE)
        if self._speed.value != job.speed:
            self._speed.set_value(job.speed)
        if not self.is_flying:
            text = _verdict(job)
        elif flown is None:
            text = f"Getting ready: {job.planner} plans before the flight ..."
        else:
            clear = "" if math.isnan(flown.clearance_m) else f" · {flown.clearance_m:.0f} m clear"
            text = f"{flown.time_s:.0f} s · {flown.speed_m_s:.0f} m/s{clear} · {_DOES[flown.kind]}"
        if self._state.text != text:
            self._state.text = text


def _words(changes: Sequence[Mapping[str, Any]]) -> str:
    """Describe the time of the latest new path."""
    needed = [change for change in changes if change["needed"] or change["active_ms"] is not None]
    if not needed:
        return ""
    change = needed[-1]
    if change["active_ms"] is None:
        return "Planning ..."
    chip, trips, host = (
        sum(attempt[key] for attempt in change["attempts"])
        for key in ("chip_ms", "round_trips_ms", "host_ms")
    )
    parts = f"host {host:.0f}"
    if chip:
        parts = f"chip and line {chip:.1f}; assumed: round trips {trips:.0f}, {parts}"
    return f"New path after {change['active_ms']:.1f} ms and {change['flown_m']:.2f} m ({parts})"


def _verdict(job: FlightJob) -> str:
    """Describe the end of a flight."""
    outcome = job.outcome
    if outcome is None:
        return job.error or ""
    verdict = "✓ everything kept" if outcome["kept"] else f"✗ {outcome['breaks'][0]}"
    saving = " · saving ..." if job.state == "found" else ""
    saving = f" · {job.error}" if job.error else saving
    return (
        f"{outcome['ended'].capitalize()} after {outcome['flight_time_s']:.0f} s · {verdict} · "
        f"{outcome['clearance_flown_m']:.0f} m clear at least{saving}"
    )
