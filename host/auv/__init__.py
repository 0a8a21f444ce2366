"""The problem of *cheng*: an autonomous underwater vehicle over one of two seabed landscapes.

:func:`pathgene.host.auv.plan.evolve` runs a planner on it;
:class:`pathgene.host.auv.field.AuvField` defines the fitness of its paths. The module is light to
import, as the command line needs it.
"""

__all__ = ["PLANNERS"]

#: The planners of the paper; the one that it proposes comes first.
PLANNERS = ("ga-dp", "ga-auv")
