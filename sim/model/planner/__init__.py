"""The whole planner core, as a bit-exact integer model.

:mod:`pathgene.sim.model.planner.definition` is the plain model, a module for each unit; the modules
here are the same units, compiled. Both have a function ``plan`` in their module ``run``, with the
same arguments and the same result. ``docs/chip_planner.md`` says in words what they compute, and
why.
"""
