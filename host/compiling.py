"""First compilation of the evaluation's kernels, in a process of its own.

``python -m pathgene.host.compiling rules|paper PARENT`` compiles the kernels that every evaluation
needs and leaves them in numba's cache. A compilation in the process of a command would delay its
signals by up to a minute, since it cannot be interrupted.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from pathlib import Path


__all__ = ["compile_evaluation", "compile_first"]

_LOOK_S = 0.5


def compile_first(*, as_paper: bool) -> None:
    """Compile the kernels of the evaluation in another process, and wait for its end.

    A signal ends the wait and that process. If the process fails, the kernels are compiled when
    they are needed.
    """
    rules = "paper" if as_paper else "rules"
    folder = str(Path(__file__).absolute().parents[2])
    path = os.pathsep.join(filter(None, (folder, os.environ.get("PYTHONPATH"))))
    with subprocess.Popen(
        [sys.executable, "-m", "pathgene.host.compiling", rules, str(os.getpid())],
        env={**os.environ, "PYTHONPATH": path},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as process:
        try:
            process.wait()
        finally:
            process.kill()


def compile_evaluation(*, as_paper: bool) -> None:
    """Evaluate two small problems, one with zones and one without, as a search and a report do."""
    import numpy as np

    from pathgene.host.evaluation import Evaluator
    from pathgene.host.problem.problem import Problem
    from pathgene.host.problem.zones import Zone
    from pathgene.host.terrain import Terrain

    terrain = Terrain("flat", np.full((30, 30), 100.0), 100.0, 100.0)
    ends = (500.0, 500.0, 250.0), (2500.0, 2500.0, 250.0)
    corners = [(100.0, 2000.0), (400.0, 2000.0), (100.0, 2500.0)]
    for zones in ((), (Zone.circle(2000, 800, 100), Zone.polygon(corners))):
        problem = Problem(terrain, *ends, zones=zones, as_paper=as_paper)
        evaluator = Evaluator(problem)
        path = np.array([ends[0], (1500.0, 1400.0, 260.0), ends[1]])
        paths, lengths = np.repeat(path[None], 4, axis=0), np.full(4, len(path), dtype=np.int64)
        evaluator.evaluate(path)
        evaluator.fitness(paths, lengths)
        for fine in (False, True):
            evaluator.penalty_cost(paths, lengths, fine=fine)
        if not as_paper:
            evaluator.fitness(paths, lengths, strict=True)
            evaluator.lowest_at_m(path)


def _end_with(parent: int) -> None:
    """End this process when its parent has ended without ending it."""
    while os.getppid() == parent:
        time.sleep(_LOOK_S)
    os._exit(1)


if __name__ == "__main__":
    threading.Thread(target=_end_with, args=(int(sys.argv[2]),), daemon=True).start()
    compile_evaluation(as_paper=sys.argv[1] == "paper")
