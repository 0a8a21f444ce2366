"""The planner core as a bit-exact integer model, compiled.

A module for each unit. Score, walk and wavefront are written for a processor, and
:mod:`pathgene.sim.model.planner.definition` defines them in plain Python. ``docs/chip_planner.md``
says in words what the modules compute, and why.
"""
