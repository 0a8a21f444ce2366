"""Runs in several processes, some of which die."""

import errno
import multiprocessing
import multiprocessing.synchronize
import sys

import pytest

from pathgene.host.compare.runs import Task, run_in_processes, run_on_cluster
from pathgene.host.errors import InputError, JobError
from tests.support.host.pool import local_cluster


def tasks_of(entrants, seeds):
    return [Task(entrant, seed) for seed in seeds for entrant in entrants]


def found(outcomes):
    """Return the parts of an outcome that do not depend on the process."""
    outcomes = list(outcomes)
    assert not [outcome.failure for outcome in outcomes if outcome.failure]
    return {
        (outcome.task.entrant.label, outcome.task.seed): (
            outcome.record["waypoints"],
            outcome.record["history"],
        )
        for outcome in outcomes
    }


def new_children(before):
    return [child for child in multiprocessing.active_children() if child not in before]


@pytest.mark.long
def test_a_dead_process_loses_no_run(problem, entrants):
    tasks = tasks_of(entrants, range(3))
    before = multiprocessing.active_children()
    outcomes = run_in_processes(problem, tasks, 2)
    first = next(outcomes)
    assert len(new_children(before)) == 2
    new_children(before)[0].kill()
    assert found([first, *outcomes]) == found(run_in_processes(problem, tasks, 1))
    assert not new_children(before)


@pytest.mark.long
def test_a_closed_comparison_leaves_no_process(problem, entrants):
    before = multiprocessing.active_children()
    outcomes = run_in_processes(problem, tasks_of(entrants, range(100)), 2)
    next(outcomes)
    outcomes.close()
    assert not new_children(before)


def test_a_cluster_by_its_address(problem, entrants):
    tasks = tasks_of(entrants, range(1))
    with local_cluster() as cluster:
        address = cluster.scheduler_address
        assert address.startswith("tcp://")
        there = found(run_on_cluster(problem, tasks, address, 1))
    assert there == found(run_in_processes(problem, tasks, 1))


def test_reports_the_loss_of_the_scheduler(problem, entrants):
    with local_cluster() as cluster:
        address = cluster.scheduler_address
        outcomes = run_on_cluster(problem, tasks_of(entrants, range(50)), address, 1)
        assert next(outcomes).failure is None
    with pytest.raises(JobError) as caught:
        list(outcomes)
    assert str(caught.value) == (
        f"The Dask scheduler at {address!r} is lost; repeat the command to continue."
    )


def test_reports_a_missing_scheduler(problem, entrants, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("pathgene.host.workers.cluster._CONNECT_TIMEOUT_S", 0.5)
    with pytest.raises(InputError) as caught:
        next(run_on_cluster(problem, tasks_of(entrants, range(1)), "tcp://127.0.0.1:9", 1))
    assert str(caught.value).startswith("No Dask scheduler answers at 'tcp://127.0.0.1:9' (")
    assert str(caught.value).endswith("; start one with 'dask scheduler', or give 'local'.")


def test_names_the_missing_extra(problem, entrants, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError) as caught:
        next(run_on_cluster(problem, tasks_of(entrants, range(1)), "local", 1))
    assert str(caught.value) == (
        "A Dask cluster needs the package distributed; install "
        "pathgene[cluster], or leave --scheduler out."
    )


@pytest.mark.long
def test_a_lost_worker_loses_no_run(problem, entrants):
    pytest.importorskip("distributed")
    tasks = tasks_of(entrants, range(10))
    before = multiprocessing.active_children()
    outcomes = run_on_cluster(problem, tasks, "local", 2)
    first = next(outcomes)
    workers = new_children(before)
    assert len(workers) == 2
    for worker in workers:  # Both die, so the problem must be sent again.
        worker.kill()
    assert found([first, *outcomes]) == found(run_in_processes(problem, tasks, 1))
    assert not new_children(before)


def test_a_machine_without_semaphores(problem, entrants, monkeypatch):
    """As if /dev/shm were read-only."""

    def refuse(*_arguments, **_options):
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(multiprocessing.synchronize._multiprocessing, "SemLock", refuse)
    with pytest.raises(JobError) as caught:
        list(run_in_processes(problem, tasks_of(entrants, range(2)), 2))
    assert str(caught.value) == (
        "No processes can be started here (Read-only file system); give --jobs 1, or make "
        "/dev/shm writable."
    )
