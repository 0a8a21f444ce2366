"""A page that looks at a flight: the aircraft in the views, and what happens and is decided."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

from host.web.desk.flight import AHEAD, CLEAR, FASTEST, Flown, Speed
from host.web.desk.job import FlightJob
from host.web.desk.jobs import Jobs
from host.web.desk.stage import Stage


__all__ = ["Cockpit"]

_POLL_S = 0.04
# Speeds to choose from; 0 lets the time stand still.
_SPEEDS = {0: "stands still", 1: "1 ×", 4: "4 ×", 16: "16 ×", int(FASTEST): f"{FASTEST:.0f} ×"}
_FIRST = 4
# Sentences that are shown, the latest first.
_SENTENCES = 40
_END, _CLOSE = "End flight", "Close flight"
_DOES = {"path": "on its path", "holding": "on a safe circle", "way-out": "leaving a zone"}


class Cockpit:
    """The flight that a page looks at, if any. The elements are added where it is made.

    Parameters
    ----------
    jobs : Jobs
        The jobs of the desk.
    ended : callable
        Called when the flight has ended.
    """

    def __init__(self, jobs: Jobs, ended: Callable[[], object]) -> None:
        self._jobs, self._ended = jobs, ended
        self._stage: Stage | None = None
        self._job: FlightJob | None = None
        self._seen = 0
        self._timer = ui.timer(_POLL_S, self._look, active=False)
        with ui.element("div").classes("cockpit") as self._root:
            with ui.element("header"):
                ui.html("<h2>Flight</h2>", sanitize=False)
                self._end = ui.button(_END, on_click=self.end).props("flat dense no-caps")
            self._state = ui.label().classes("readout").props('data-role="flying"')
            with ui.row().classes("actions"):
                self._speed = ui.select(
                    _SPEEDS, label="speed", value=_FIRST, on_change=self._set_speed
                ).props("dense outlined options-dense stack-label")
                self._buttons = [
                    ui.button(text, on_click=act).props("outline dense no-caps")
                    for text, act in (
                        ("Zone ahead", lambda: self.order(AHEAD)),
                        ("Zones away", lambda: self.order(CLEAR)),
                    )
                ]
            self._latest = ui.label().classes("latest").props('role=status data-role="replan"')
            self._log = ui.element("ol").classes("log").props('aria-label="What has happened"')
        self._root.set_visibility(False)
        # Nobody else would let it go on.
        ui.context.client.on_delete(self.leave)

    def show_in(self, stage: Stage) -> None:
        """Set where the aircraft is shown."""
        self._stage = stage

    @property
    def is_open(self) -> bool:
        """True while the page shows a flight, or the end of one."""
        return self._job is not None

    @property
    def is_flying(self) -> bool:
        """True while a flight goes on that this page looks at."""
        return self._job is not None and self._job.state == "flying"

    def follow(self, job: FlightJob) -> None:
        """Show a flight from its beginning."""
        assert self._stage is not None
        self._job, self._seen = job, 0
        self._latest.text = ""
        self._log.clear()
        self._speed.set_value(_FIRST)
        self._root.set_visibility(True)
        self._stage.fly()
        self._timer.activate()
        self._look()

    def leave(self) -> None:
        """Look at no flight; one that goes on does so at the greatest speed."""
        if self._job is None:
            return
        if self.is_flying:
            self.order(Speed(FASTEST))
        self._job = None
        self._timer.deactivate()
        self._root.set_visibility(False)
        if self._stage is not None:
            self._stage.land()

    def order(self, order: object) -> None:
        """Let something happen in the flight: see :mod:`host.web.desk.flight`."""
        if self._job is not None:
            self._jobs.tell(self._job, order)

    def end(self) -> None:
        """End the flight where it is; show it no more where it has ended."""
        if self._job is None or self._job.done:
            self.leave()
        else:
            self._jobs.stop(self._job)

    def _set_speed(self) -> None:
        self.order(Speed(float(self._speed.value)))

    def _look(self) -> None:
        """Show what has come of the flight since the last look."""
        job = self._job
        if job is None:
            return
        is_done = job.done
        seen = job.seen[self._seen :]
        self._seen += len(seen)
        if seen:
            assert self._stage is not None
            self._stage.flown(_together(seen))
            for each in seen:
                for sentence in each.said:
                    self._add(sentence)
                if each.changes:
                    self._show_latest(each.changes)
        self._show_state(job, seen[-1] if seen else None)
        if is_done:
            self._timer.deactivate()
            self._ended()

    def _add(self, sentence: str) -> None:
        with self._log:
            with ui.element("li") as item:
                ui.label(sentence).classes("word")
            item.move(target_index=0)
        for old in self._log.default_slot.children[_SENTENCES:]:
            old.delete()

    def _show_latest(self, changes: list[dict[str, Any]]) -> None:
        done = [change for change in changes if change["active_ms"] is not None]
        if done:
            self._latest.text = _words(done[-1])

    def _show_state(self, job: FlightJob, flown: Flown | None) -> None:
        """Say what the aircraft does, and offer what has an effect."""
        for element in (self._speed, *self._buttons):
            element.set_enabled(job.state == "flying" and bool(job.seen))
        self._end.set_text(_CLOSE if job.done else _END)
        if job.done or job.state == "found":
            text = _verdict(job)
        elif flown is not None:
            clear = "" if math.isnan(flown.clearance_m) else f" · {flown.clearance_m:.0f} m clear"
            text = f"{flown.time_s:.0f} s · {flown.speed_m_s:.0f} m/s{clear} · {_DOES[flown.kind]}"
        elif job.seen:
            return
        else:
            text = f"Getting ready: {job.planner} plans once before the flight ..."
        self._state.text = text


def _together(seen: list[Flown]) -> dict[str, Any]:
    """Return what the stage takes for several messages."""

    def latest(name: str) -> Any:
        values = (getattr(each, name) for each in reversed(seen))
        return next((value for value in values if value is not None), None)

    return {
        "aircraft": seen[-1].aircraft,
        "trail": [point for each in seen for point in each.trail],
        "versions": [version for each in seen for version in each.versions],
        **{name: latest(name) for name in ("zones", "points", "path")},
    }


def _words(change: Mapping[str, Any]) -> str:
    """Return the time of a new path in words."""
    tries = change["attempts"]
    chip, trips, host = (
        sum(attempt[key] for attempt in tries) for key in ("chip_ms", "round_trips_ms", "host_ms")
    )
    parts = f"host {host:.0f}"
    if chip:
        parts = f"chip and line {chip:.1f}, round trips {trips:.0f}, {parts}"
    return f"New path after {change['active_ms']:.1f} ms and {change['flown_m']:.2f} m ({parts})"


def _verdict(job: FlightJob) -> str:
    """Return the end of a flight in words."""
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
