"""The planners of *cheng* for any problem: routes of B-splines between crossover points.

:mod:`~host.planners.routes.field` defines a problem, :mod:`~host.planners.routes.search` has the
two searches, :mod:`~host.planners.routes.programming` the deterministic crossover.
"""
