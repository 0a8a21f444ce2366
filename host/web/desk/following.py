"""A page that follows a job: generations in the views, state in words, and plan."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable

from nicegui import ui

from pathgene.host.web.desk.job import PlanJob
from pathgene.host.web.desk.jobs import Jobs
from pathgene.host.web.desk.results import PlanView, Results
from pathgene.host.web.desk.stage import Stage


__all__ = ["Following"]

# Polling period of a job, seconds. The views draw many generations with each frame.
_POLL_S = 0.05
# Maximum generations per poll. If there are more, some are skipped.
_MOST_ROWS = 250


class Following:
    """The job that a page follows, if any. Its elements are added where it is constructed."""

    def __init__(self, jobs: Jobs, ended: Callable[[], object]) -> None:
        self._jobs, self._ended = jobs, ended
        self._stage: Stage | None = None
        self._results: Results | None = None
        self._job: PlanJob | None = None
        self._sent = self._sent_paths = 0
        self._stop = ui.button("Stop", on_click=self.stop).props("outline no-caps")
        self._status = ui.label().classes("status").props("aria-live=polite")
        self._timer = ui.timer(_POLL_S, self._look, active=False)
        self._show_state()

    def show_in(self, stage: Stage, results: Results) -> None:
        """Set the views in which the generations and the plan are shown."""
        self._stage, self._results = stage, results

    def follow(self, job: PlanJob) -> None:
        """Show the generations of a job as they arrive, beginning with the first."""
        assert self._stage is not None
        assert self._results is not None
        self._job = job
        self._sent = self._sent_paths = 0
        self._stage.begin()
        self._results.show(None, self._results.kept)
        self._timer.activate()
        self._show_state()

    def leave(self) -> None:
        """Follow no job. The job continues."""
        self._job = None
        self._timer.deactivate()
        self._show_state()

    async def stop(self) -> None:
        """Ask the job to end with its best path."""
        if self._job is not None:
            await asyncio.to_thread(self._jobs.stop, self._job)
            self._show_state()

    def _look(self) -> None:
        """Show the progress of the job since the previous call."""
        job = self._job
        if job is None:
            return
        is_done = job.done
        self._send_rows(job)
        self._show_plan(job)
        if is_done:
            self._timer.deactivate()
            self._ended()
        self._show_state()

    def _send_rows(self, job: PlanJob) -> None:
        assert self._stage is not None
        rows, paths = job.rows[self._sent :], job.paths[self._sent_paths :]
        if not rows:
            return
        # A path may arrive before its row.
        last = rows[-1][0]
        better = {generation: path.tolist() for generation, path in paths if generation <= last}
        self._sent += len(rows)
        self._sent_paths += len(better)
        every = math.ceil(len(rows) / _MOST_ROWS)
        self._stage.progress(
            [
                [*row, better.get(row[0])]
                for number, row in enumerate(rows, start=1)
                if number % every == 0 or number == len(rows) or row[0] in better
            ]
        )

    def _show_plan(self, job: PlanJob) -> None:
        """Show the plan and its files, each as soon as it is available."""
        assert self._stage is not None
        assert self._results is not None
        state, before = job.state, self._results.plan
        if job.summary is None or job.path is None:
            return
        if before is None or before.state != state:
            plan = PlanView(job.summary, job.path, job.folder, state, job.statement)
            if before is None:
                self._stage.set_plan(plan.to_json())
            self._results.show(plan, self._results.kept)

    def _show_state(self) -> None:
        """Show the state of the job, and enable Stop if it has an effect."""
        job = self._job
        can_stop = job is not None and job.state in ("waiting", "planning") and not job.stopping
        self._stop.set_enabled(can_stop)
        text = "" if job is None else self._words(job)
        if self._status.text != text:
            self._status.text = text

    def _words(self, job: PlanJob) -> str:
        if job.state == "waiting":
            ahead = self._jobs.ahead_of(job)
            return f"Waiting, {ahead} others first ..." if ahead else "Waiting, next ..."
        if job.state == "planning":
            return "Stopping ..." if job.stopping else "Planning ..."
        if job.state == "found":
            return "Saving ..."
        return f"Saved in {job.folder}" if job.state == "saved" else job.error or ""
