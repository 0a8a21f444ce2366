"""A stand-in for pools of processes."""

from concurrent.futures import ThreadPoolExecutor


class Pool(ThreadPoolExecutor):
    """The pool of processes, in a thread of this process that needs no preparation."""

    def __init__(self, workers=None, context=None, prepare=None, arguments=()):
        super().__init__(1)
