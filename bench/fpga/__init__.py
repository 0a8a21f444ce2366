"""Area and speed on real devices: every board, every unit alone, the papers' own families.

The synthesis and place-and-route tools run for hours; ``make setup-synth`` installs them. A row is
kept in ``docs/results.json`` as soon as it is measured, and is measured again only when its circuit
or the tools have changed (:mod:`bench.fpga.store`); ``docs/boards.md`` shows all rows.
"""

from __future__ import annotations

import os
import sys
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

from bench import pages
from bench.fpga.boards import BOARDS_TABLE, LANES_TABLE, board_jobs, lanes_jobs
from bench.fpga.job import Job, Measured
from bench.fpga.store import Store, Table
from bench.fpga.units import PAPERS_TABLE, UNITS_TABLE, paper_jobs, unit_jobs
from bench.report import Options, Report
from pathgene.host.errors import InputError, PathgeneError


__all__ = ["TABLES", "run", "tables"]

_ROOT = Path(__file__).parents[2]
_FOLDER = _ROOT / "build" / "fpga"
STORE = _ROOT / "docs" / "results.json"

TABLES: tuple[Table, ...] = (BOARDS_TABLE, LANES_TABLE, UNITS_TABLE, PAPERS_TABLE)


def run(options: Options) -> Report:
    """Measure the missing rows, keep and write them, and return the boards' table."""
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
    report.data = {table.name: store.rows(table.name) for table in TABLES}
    return report


def tables(store: Store) -> Report:
    """Return the tables of all rows."""
    first, *further = (table.report(store) for table in TABLES)
    return replace(first, further=further)


def _measure(jobs: list[Job], store: Store) -> list[str]:
    """Run the jobs whose rows are not in ``store``, one a core; return why some failed."""
    failed: list[str] = []
    # Each job mostly waits for the tools that it runs.
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        running: dict[Future[Measured | None], Job] = {}
        try:
            for job in jobs:
                known = store.digest(job.table, job.name)
                running[pool.submit(job.measure_unless, known, _FOLDER)] = job
            while running:
                ended, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in ended:
                    job = running.pop(future)
                    try:
                        measured = future.result()
                    except PathgeneError as error:
                        failed.append(f"{job.name}: {error}")
                        print(f"{job.table}: {failed[-1]}", file=sys.stderr, flush=True)
                        continue
                    if measured is not None:
                        store.keep(job.table, job.name, measured)
                        print(f"{job.table}: {job.name} done", file=sys.stderr, flush=True)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return failed
