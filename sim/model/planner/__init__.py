"""The planner core as a bit-exact integer model, compiled.

A module for each unit. Score, walk and wavefront are written for a processor, and
:mod:`pathgene.sim.model.planner.definition` defines them in plain Python. ``docs/chip_planner.md``
explains in words the computation and its reasons.
"""
