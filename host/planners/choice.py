"""The final choice of a planner among its candidates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluation, Evaluator


__all__ = ["choose"]

Path = NDArray[np.float64]

_CHOICE_BATCH = 64


def choose(evaluator: Evaluator, archive: Sequence[tuple[float, Path]]) -> tuple[Path, Evaluation]:
    """Return the best candidate that is feasible by the strict rule, or the best if none is.

    Strict means that the penalty is also 0 when sampled 8 times finer.

    Parameters
    ----------
    archive : sequence of (float, ndarray)
        Fitness and path of the candidates, best first; at least one.
    """
    for first in range(0, len(archive), _CHOICE_BATCH):
        batch = [path for fitness, path in archive[first : first + _CHOICE_BATCH] if fitness > 1]
        if not batch:
            break
        lengths = np.array([len(path) for path in batch], dtype=np.int64)
        padded = np.zeros((len(batch), int(lengths.max()), 3))
        for row, path in zip(padded, batch, strict=True):
            row[: len(path)] = path
        penalty, _ = evaluator.penalty_cost(padded, lengths, fine=True)
        for path in (batch[i] for i in np.flatnonzero(penalty == 0)):
            evaluation = evaluator.evaluate(path)
            if evaluation.feasible:
                return path, evaluation
    path = archive[0][1]
    return path, evaluator.evaluate(path)
