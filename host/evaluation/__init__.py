"""The evaluation of paths: one definition for every planner, the reports and the tests.

:class:`Evaluator` is the interface. :mod:`~pathgene.host.evaluation.reference` is the definition in
plain Python; :mod:`~pathgene.host.evaluation.kernels` with :mod:`~pathgene.host.evaluation.pieces`
is the same, compiled, and is loaded with the first evaluator.
"""

from pathgene.host.evaluation.evaluator import Evaluator
from pathgene.host.evaluation.geometry import Arc, Straight
from pathgene.host.evaluation.reference import line_utopia, problem_utopia, utopia
from pathgene.host.evaluation.terms import Evaluation
from pathgene.host.evaluation.track import Samples, SmoothedTrack


__all__ = [
    "Arc",
    "Evaluation",
    "Evaluator",
    "Samples",
    "SmoothedTrack",
    "Straight",
    "line_utopia",
    "problem_utopia",
    "utopia",
]
