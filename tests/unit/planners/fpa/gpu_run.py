"""Run some iterations of the GPU engine in a new process, because numba chooses its GPU once.

``python gpu_run.py FILE`` reads a pickle of runs (problem, seed, paths, fitness), iterations,
two_opt_every, stride and keywords of the engine, and writes a pickle of leaders and populations to
FILE.out.
"""

import pickle
import sys
from pathlib import Path

import numpy as np

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.airspace import Airspace
from pathgene.host.planners.fpa.cuda import GpuEngine
from pathgene.host.planners.fpa.engines import Setup
from pathgene.host.planners.fpa.steps import Pollination


def main():
    file = Path(sys.argv[1])
    runs, iterations, every, stride, options = pickle.loads(file.read_bytes())
    setups = []
    for problem, seed, paths, fitness in runs:
        space = Airspace(problem)
        setups.append(
            Setup(
                Evaluator(problem, threads=1),
                Pollination(np.uint64(seed), iterations, 0.5, 0.25, 0.02),
                np.stack((space.low, space.high)),
                paths,
                fitness,
            )
        )
    engine = GpuEngine(setups, every, stride=stride, **options)
    leaders = [[] for _ in runs]
    for first in range(1, iterations + 1, stride):
        some = engine.advance(first, min(stride, iterations + 1 - first))
        for own, found in zip(leaders, some, strict=True):
            own += map(tuple, found)
    file.with_suffix(".out").write_bytes(pickle.dumps((leaders, engine.populations())))


if __name__ == "__main__":
    main()
