"""Score, walk and wavefront, plain: the definition that their kernels are held to.

These kernels are written for a processor, without a division where the definition has one. The
definition is written to be read: Python integers, a function for each unit. All other kernels of
:mod:`pathgene.sim.model.planner` are definitions themselves.
"""
