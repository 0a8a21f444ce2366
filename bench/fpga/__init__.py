"""Area and speed on real devices: every board, every single unit, the papers' device families.

The synthesis and place-and-route tools run for hours; ``make setup-synth`` installs them. A row is
stored in ``docs/results.json`` as soon as it is measured, and is only measured again when its
circuit or the tools have changed (:mod:`bench.fpga.job`); ``docs/boards.md`` shows all rows.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from bench import pages
from bench.campaign import measure
from bench.fpga.boards import BOARDS_TABLE, LANES_TABLE, board_jobs, lanes_jobs
from bench.fpga.job import Job, Measured, Table, rows
from bench.fpga.units import PAPERS_TABLE, UNITS_TABLE, paper_jobs, unit_jobs
from bench.report import Options, Report
from bench.store import Store
from pathgene.host.errors import InputError, PathgeneError


_ROOT = Path(__file__).parents[2]
_FOLDER = _ROOT / "build" / "fpga"
STORE = _ROOT / "docs" / "results.json"

TABLES: tuple[Table, ...] = (BOARDS_TABLE, LANES_TABLE, UNITS_TABLE, PAPERS_TABLE)


def run(options: Options) -> Report:
    """Measure the missing rows, store and write them, and return the boards' table."""
    store = Store(STORE)
    jobs = [*board_jobs(), *lanes_jobs(), *unit_jobs(), *paper_jobs()]
    if options.only:
        jobs = [job for job in jobs if options.only in f"{job.table}: {job.name}"]
        if not jobs:
            raise InputError(f"No row of the benchmark has {options.only!r} in its name.")
    failed = _measure(jobs, store)
    pages.keep("fpga", tables(store))
    report = BOARDS_TABLE.report(store)
    report.notes += failed
    report.failed = bool(failed)
    report.data = {table.name: rows(store, table.name) for table in TABLES}
    return report


def tables(store: Store) -> Report:
    """Return the tables of all rows."""
    first, *further = (table.report(store) for table in TABLES)
    return replace(first, further=further)


def _measure(jobs: list[Job], store: Store) -> list[str]:
    """Run the jobs whose rows are not in ``store``, one per core; return why some failed."""
    failed: list[str] = []

    def keep(task: tuple[Job, str | None, Path], measured: Measured | None) -> None:
        job, _, _ = task
        if measured is not None:
            store.keep(job.table, job.name, {"row": measured.row}, measured.digest)

    def give_up(task: tuple[Job, str | None, Path], error: PathgeneError) -> None:
        job, _, _ = task
        failed.append(f"{job.name}: {error}")
        print(f"{job.table}: {failed[-1]}", file=sys.stderr, flush=True)

    measure(
        "fpga",
        [(job, store.digest(job.table, job.name), _FOLDER) for job in jobs],
        Job.measure_unless,
        name=lambda task: f"{task[0].table}, {task[0].name}",
        keep=keep,
        failed=give_up,
        spawned=True,
    )
    return failed
