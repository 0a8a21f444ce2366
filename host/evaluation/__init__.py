"""The evaluation of paths: one definition for every planner, the reports and the tests.

:class:`Evaluator` is the interface. :mod:`~host.evaluation.reference` is the definition in plain
Python; :mod:`~host.evaluation.kernels` with :mod:`~host.evaluation.pieces` is the same, compiled,
and is loaded with the first evaluator.
"""

from host.evaluation.evaluator import Evaluator
from host.evaluation.geometry import Arc, Straight
from host.evaluation.reference import problem_utopia, utopia
from host.evaluation.terms import Evaluation
from host.evaluation.track import Samples, SmoothedTrack


__all__ = [
    "Arc",
    "Evaluation",
    "Evaluator",
    "Samples",
    "SmoothedTrack",
    "Straight",
    "problem_utopia",
    "utopia",
]
