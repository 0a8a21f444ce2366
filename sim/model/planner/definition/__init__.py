"""Score, walk and wavefront in plain Python: the reference for their kernels.

The kernels are optimized for a CPU and avoid divisions of the definition. The definition is written
for readability: Python integers, one function per unit. All other kernels of
:mod:`pathgene.sim.model.planner` are definitions themselves.
"""
