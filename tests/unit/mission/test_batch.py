"""Jobs of a batch: names, keys, and execution in this process, in several and on a cluster."""

import multiprocessing

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.mission.batch import Job, execute, kept_summary, names_of, save
from pathgene.host.mission.problem_file import read_problem
from tests.support.host.pool import local_cluster


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("batch")
    y, x = np.mgrid[:31, :41]
    hills = 300 + 100 * np.sin(x / 8) * np.cos(y / 6)
    np.savez(made / "hills.npz", elevation=hills, dx_m=100.0, dy_m=100.0)
    return made


@pytest.fixture
def job(folder):
    """Function that makes a job of a problem over the hills."""

    def make(name="one", goal="[3500, 2500, 100]", extra="", more=""):
        file = folder / f"{name}.toml"
        file.write_text(f"""
[terrain]
source = "hills.npz"
[mission]
start = [500, 500, 100]
goal = {goal}
agl = true
{extra}
[planner]
name = "astar"
[output]
picture = false
{more}
""")
        return Job(name, str(file), read_problem(file))

    return make


def test_names_are_those_of_the_files_or_of_their_folders():
    assert names_of(["a/x.toml", "b/y.toml"]) == ["x", "y"]
    assert names_of(["a/x.toml", "b/x.toml", "b/y.toml"]) == ["a-x", "b-x", "y"]
    with pytest.raises(InputError) as error:
        names_of(["a/x.toml", "a/x.toml"])
    assert str(error.value) == (
        "The results of a/x.toml and a/x.toml would have one name, 'a-x'; rename one of the files."
    )


def test_the_key_depends_on_what_is_planned_alone(job, folder):
    key = job().key
    assert job("other").key == key
    assert job(more="# a comment").key == key
    assert job(more='out = "elsewhere"').key == key
    assert job(extra="wind = [1, 2]").key != key
    assert job(goal="[3500, 2500, 101]").key != key
    heights = folder / "hills.npz"
    before = heights.read_bytes()
    np.savez(heights, elevation=np.full((31, 41), 310.0), dx_m=100.0, dy_m=100.0)
    assert job().key != key
    heights.write_bytes(before)
    assert job().key == key


def found(outcomes):
    return {
        job.name: (out.result and out.result.path.tolist(), out.failure) for job, out in outcomes
    }


@pytest.mark.ci
def test_a_bad_problem_stops_no_other(job, tmp_path):
    jobs = [
        job("off", goal="[9000, 0, 100]"),
        job("good"),
        job("mission", extra="via = [[2500, 800, 150]]"),
        job("shut", more="[[zones]]\ncircle = [3500, 2500, 1]"),
    ]
    outcomes = {job.name: (job, out) for job, out in execute(jobs, 1, None)}
    assert list(outcomes) == ["off", "shut", "good", "mission"]
    assert outcomes["off"][1].bad_input
    assert outcomes["off"][1].failure.startswith("The goal at (9000, 0) is outside the map")
    assert outcomes["good"][1].failure is None
    assert len(outcomes["mission"][1].summary["legs"]) == 2
    for name in ("good", "mission"):
        made, outcome = outcomes[name]
        assert kept_summary(tmp_path, made) is None
        save(tmp_path, made, outcome, print)
        assert kept_summary(tmp_path, made)["waypoints"] == outcome.result.path.tolist()
    assert kept_summary(tmp_path, job("good", extra="wind = [1, 2]")) is None


@pytest.mark.ci
def test_processes_plan_the_same(job):
    jobs = [job("one"), job("two", goal="[3000, 1500, 100]"), job("three", extra="wind = [2, 1]")]
    assert found(execute(jobs, 2, None)) == found(execute(jobs, 1, None))
    assert not multiprocessing.active_children()


@pytest.mark.ci
def test_a_cluster_plans_the_same(job):
    jobs = [job("one"), job("two", goal="[3000, 1500, 100]")]
    with local_cluster() as cluster:
        there = found(execute(jobs, 1, cluster.scheduler_address))
    assert there == found(execute(jobs, 1, None))


def test_a_board_here_is_not_reached_from_a_cluster(job):
    made = job()
    values = {**made.values, "planner": "ga-fpga", "board": "/dev/ttyUSB0"}
    ((_, outcome),) = execute([Job("one", made.file, values)], 1, "tcp://127.0.0.1:9")
    assert outcome.bad_input
    assert outcome.failure.startswith("A board at this machine cannot be reached from a cluster; ")


def test_jobs_share_their_terrain(job, monkeypatch):
    from pathgene.host.mission import build

    loaded = []
    own = build.load

    def noting(source, **options):
        loaded.append(source)
        return own(source, **options)

    monkeypatch.setattr(build, "load", noting)
    jobs = [
        job(f"shared-{at}", goal=f"[3500, {2000 + 100 * at}, 100]", more="grid = false")
        for at in range(4)
    ]
    jobs.append(job("filled", extra="", more="grid = false"))
    jobs[-1].values["fill_voids"] = True
    here = {done.name: outcome for done, outcome in execute(jobs, 1, None)}
    assert len(loaded) == 2  # One of them has its voids filled.
    assert len({id(here[f"shared-{at}"].terrain) for at in range(4)}) == 1
    there = {done.name: outcome for done, outcome in execute(jobs, 2, None)}
    assert len(loaded) == 4
    for name, outcome in here.items():
        np.testing.assert_array_equal(outcome.result.path, there[name].result.path)
        assert outcome.summary["feasible"]
