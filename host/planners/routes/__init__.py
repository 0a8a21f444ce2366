"""The planners of *cheng*, whatever their problem: routes of B-splines between crossover points.

:mod:`~host.planners.routes.field` says what a problem is to them,
:mod:`~host.planners.routes.search` has the two searches,
:mod:`~host.planners.routes.programming` the deterministic crossover.
"""
