"""What a path is worth: one definition for every planner, the reports and the tests.

:class:`Evaluator` is what users call. :mod:`~host.evaluation.reference` is the definition in plain
Python, :mod:`~host.evaluation.kernels` with :mod:`~host.evaluation.pieces` the same compiled.
"""

from host.evaluation.evaluator import Evaluation, Evaluator
from host.evaluation.geometry import Arc, Straight
from host.evaluation.track import Samples, SmoothedTrack


__all__ = ["Arc", "Evaluation", "Evaluator", "Samples", "SmoothedTrack", "Straight"]
