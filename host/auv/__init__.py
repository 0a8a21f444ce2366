"""The problem of *cheng*: an autonomous underwater vehicle over one of two seabed landscapes.

:func:`pathgene.host.auv.plan.evolve` runs a planner on it;
:class:`pathgene.host.auv.field.AuvField` defines the fitness of its paths. Light to import, for the
command line.
"""

__all__ = ["PLANNERS"]

#: The planners of the paper, the proposed one first.
PLANNERS = ("ga-dp", "ga-auv")
