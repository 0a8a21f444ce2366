"""The planner core as a bit-exact integer model, compiled.

There is a module for each unit. Score, walk and wavefront are optimized for a CPU, and
:mod:`pathgene.sim.model.planner.definition` defines them in plain Python. ``docs/chip_planner.md``
explains the computation and its reasons in words.
"""
