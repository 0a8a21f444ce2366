"""Stand-ins for pools of processes and for clusters."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import pytest


class Pool(ThreadPoolExecutor):
    """A pool of processes replaced by a thread of this process, which needs no preparation."""

    def __init__(self, workers=None, context=None, prepare=None, arguments=()):
        super().__init__(1)


@contextmanager
def local_cluster():
    """Start a Dask cluster whose scheduler and worker are threads of this process, over TCP."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1,
        threads_per_worker=1,
        processes=False,
        protocol="tcp://",
        scheduler_kwargs={"dashboard": False},
    ) as cluster:
        yield cluster
