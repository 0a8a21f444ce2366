"""The compiler of the simulated autopilot's kernels."""

from pathgene.jit import Compiler


__all__ = ["COMPILER"]

#: Only the sources of this folder belong to the kernels.
COMPILER = Compiler()
