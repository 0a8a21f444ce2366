"""A stand-in for pools of processes."""


class Pool:
    """The pool of processes, in this process."""

    def __init__(self, workers=None, initializer=None):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *error):
        pass

    def map(self, function, tasks):
        return map(function, tasks)
