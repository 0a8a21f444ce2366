"""Run some iterations of the GPU engine in a new process, because numba chooses its GPU once.

``python gpu_run.py FILE`` reads a pickle of problem, seed, iterations, two_opt_every, stride,
threads, paths and fitness, and writes a pickle of leaders, population and counts to FILE.out.
"""

import pickle
import sys
from pathlib import Path

import numpy as np

from host.evaluation import Evaluator
from host.planners.airspace import Airspace
from host.planners.fpa.cuda import GpuEngine
from host.planners.fpa.steps import Pollination


def main():
    file = Path(sys.argv[1])
    problem, seed, iterations, every, stride, threads, paths, fitness = pickle.loads(
        file.read_bytes()
    )
    space = Airspace(problem)
    engine = GpuEngine(
        Evaluator(problem, threads=1),
        Pollination(np.uint64(seed), iterations, 0.5, 0.25, 0.02),
        every,
        np.stack((space.low, space.high)),
        paths,
        fitness,
        stride=stride,
        threads=threads,
    )
    leaders = []
    for first in range(1, iterations + 1, stride):
        leaders += engine.advance(first, min(stride, iterations + 1 - first))
    found = [tuple(leader) for leader in leaders], engine.population()
    file.with_suffix(".out").write_bytes(pickle.dumps(found))


if __name__ == "__main__":
    main()
