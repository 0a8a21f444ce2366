"""All compiled kernels in two parts, which two workers compile at the same time."""

import functools

import numpy as np

from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain
from tools.protocol_page.__main__ import contents


def compile_evaluation():
    """Compile the kernels of the evaluation, so that no command notes that it compiles them."""
    terrain = Terrain("flat", np.full((30, 30), 100.0), 100.0, 100.0)
    ends = (500.0, 500.0, 250.0), (2500.0, 2500.0, 250.0)
    for as_paper in (False, True):
        problem = Problem(terrain, *ends, as_paper=as_paper)
        Evaluator(problem, threads=1).evaluate(np.array(ends))


@functools.cache
def written_page():
    """Return the page of the protocol and its frames, written now by the kernels of the model."""
    return contents()
