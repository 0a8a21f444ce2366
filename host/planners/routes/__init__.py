"""The planners of *cheng* for any problem: routes of B-splines between crossover points.

:mod:`~pathgene.host.planners.routes.field` defines a problem,
:mod:`~pathgene.host.planners.routes.search` has the two searches,
:mod:`~pathgene.host.planners.routes.programming` the deterministic crossover.
"""
