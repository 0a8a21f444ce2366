"""Jobs in processes: progress, stop, limits and saved files."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.inputs import parse_json
from pathgene.host.mission.problem_file import read_problem
from pathgene.host.report.read import read_run
from pathgene.host.report.run_files import PICTURE, SUMMARY, verify
from pathgene.host.web.desk.jobs import Jobs
from pathgene.host.web.desk.saving import PROBLEM, files_of, saved_plans
from tests.support.host.processes import Started


CANYON = {
    "terrain": "canyon",
    "start": (300.0, 300.0, 60.0),
    "goal": (4700.0, 4600.0, 60.0),
    "agl": True,
    "planner": "ga-pc",
    "seed": 1,
    "generations": 60,
}
# Starts a job, prints the number of its process once it plans, and waits to be killed.
KILLED = f"""
import sys, time
from pathlib import Path
from pathgene.host.web.desk.jobs import Jobs

if __name__ == "__main__":
    jobs = Jobs(Path(sys.argv[1]))
    job = jobs.submit({ {**CANYON, "generations": 10_000_000}!r}, "orphan")
    while not job.rows:
        time.sleep(0.01)
    print(jobs._running[job].process.pid, flush=True)
    time.sleep(600)
"""
#: A search that lasts longer than any test, unless it is stopped.
ENDLESS = {**CANYON, "generations": 10_000_000}


@pytest.fixture(scope="module")
def jobs(tmp_path_factory):
    jobs = Jobs(tmp_path_factory.mktemp("desk") / "out", at_once=1, waiting=2)
    yield jobs
    jobs.close()


def until(condition, limit_s=180.0):
    deadline = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < deadline, "it took too long"
        time.sleep(0.01)


@pytest.mark.ci
def test_a_job_tells_its_progress_and_saves_its_plan(jobs):
    place = {"origin": (36.2, -84.4)}
    job = jobs.submit({**CANYON, **place}, "canyon-ga-pc")
    until(lambda: job.done)
    assert (job.state, job.error) == ("saved", None)
    assert [row[0] for row in job.rows] == list(range(61))
    assert [list(row) for row in job.rows] == job.summary["history"]
    best = [row[1] for row in job.rows]
    better = [0, *(n for n in range(1, 61) if best[n] > best[n - 1])]
    assert [generation for generation, _ in job.paths] == better
    folder = job.folder
    assert folder.name in saved_plans(folder.parent)
    summary = read_run(folder / SUMMARY).summary
    verify(folder / SUMMARY, summary)
    assert summary["waypoints"] == job.summary["waypoints"]
    run = read_run(folder / SUMMARY)
    assert np.array_equal(run.path, np.array(job.summary["waypoints"]))
    assert read_problem(folder / PROBLEM)["generations"] == 60
    assert {"path.plan", "path.kml", "path.waypoints"} <= set(files_of(folder))
    until((folder / PICTURE).is_file)


def test_a_terrain_without_a_place_has_a_note_and_no_files_of_ground_stations(jobs):
    job = jobs.submit(CANYON, "canyon")
    until(lambda: job.done)
    assert job.state == "saved"
    assert "path.plan" not in files_of(job.folder)
    assert len(job.notes) == 1


@pytest.mark.ci
def test_stopped_jobs_keep_their_best_path_and_others_wait_for_them(jobs):
    first = jobs.submit(ENDLESS, "first")
    second = jobs.submit(CANYON, "second")
    third = jobs.submit(CANYON, "third")
    with pytest.raises(InputError, match=r"^2 plans are waiting, and no more may; wait for one, "):
        jobs.submit(CANYON, "fourth")
    assert [jobs.ahead_of(job) for job in (first, second, third)] == [0, 0, 1]
    until(lambda: len(first.rows) > 3)
    assert (first.state, second.state) == ("planning", "waiting")
    jobs.stop(third)
    assert (third.state, third.error) == ("failed", "It was stopped before it began.")
    jobs.stop(first)
    until(lambda: first.done and second.done)
    assert (first.state, second.state) == ("saved", "saved")
    assert read_run(first.folder / SUMMARY).summary["stopped_by"] == "interrupt"
    assert read_run(second.folder / SUMMARY).summary["stopped_by"] == "generations"
    assert not third.folder.exists()


@pytest.mark.ci
def test_bad_problems_and_dead_processes_fail_alone(jobs):
    bad = jobs.submit({**CANYON, "start": (-1.0, 0.0, 50.0)}, "bad")
    until(lambda: bad.done)
    assert bad.state == "failed"
    assert bad.error.startswith("The start at (-1, 0) is outside the map")
    job = jobs.submit(ENDLESS, "killed")
    after = jobs.submit(CANYON, "after")
    until(lambda: job.rows)
    os.kill(jobs._running[job].process.pid, signal.SIGKILL)
    until(lambda: job.done and after.done)
    assert job.error == "The process of this plan ended; memory may be short."
    assert after.state == "saved"


@pytest.mark.ci
def test_a_full_folder_is_one_sentence(tmp_path):
    (tmp_path / "desk").write_text("a file, no folder")
    jobs = Jobs(tmp_path / "desk")
    job = jobs.submit(CANYON, "none")
    until(lambda: job.done)
    jobs.close()
    assert job.state == "failed"
    assert job.error.startswith("Cannot write to the directory ")
    assert job.summary["feasible"] in (True, False)


@pytest.mark.ci
def test_the_end_of_the_desk_saves_what_is_planned(tmp_path):
    jobs = Jobs(tmp_path, at_once=2)
    running = [jobs.submit(ENDLESS, f"n{number}") for number in range(2)]
    waiting = jobs.submit(CANYON, "waiting")
    until(lambda: all(job.rows for job in running))
    jobs.close()
    assert [job.state for job in running] == ["saved", "saved"]
    assert waiting.state == "failed"
    for job in running:
        assert parse_json((job.folder / SUMMARY).read_text())["interrupted"]
    with pytest.raises(InputError):
        jobs.submit(CANYON, "late")


@pytest.mark.ci
def test_a_desk_that_is_killed_leaves_no_process_and_loses_no_plan(tmp_path):
    """The process of a job ends by itself, with its best path in the folder."""
    script = tmp_path / "desk.py"
    script.write_text(KILLED)
    folder = tmp_path / "out"
    with Started([sys.executable, script, folder], stdout=subprocess.PIPE, text=True) as desk:
        pid = int(desk.stdout.readline())
        desk.kill()
    until(lambda: not Path(f"/proc/{pid}").exists())
    (name,) = saved_plans(folder)
    assert read_run(folder / name / SUMMARY).summary["interrupted"]


def test_at_least_one_job(tmp_path):
    with pytest.raises(InputError, match=r"^The desk must do 1 job at a time or more, not 0 "):
        Jobs(tmp_path, at_once=0)
