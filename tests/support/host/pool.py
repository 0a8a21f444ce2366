"""A stand-in for pools of processes."""

from concurrent.futures import ThreadPoolExecutor


class Pool(ThreadPoolExecutor):
    """A pool of processes replaced by a thread of this process, which needs no preparation."""

    def __init__(self, workers=None, context=None, prepare=None, arguments=()):
        super().__init__(1)
