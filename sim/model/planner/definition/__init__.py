"""The planner core, plain: the definition that the compiled kernels are held to.

It is written to be read, not to be fast: Python integers, a function for each unit.
"""
