"""The compiler of the host's kernels; each may be made of the sources of this package."""

from pathlib import Path

from pathgene.jit import Compiler


__all__ = ["allocating", "compiled", "inlined"]

_COMPILER = Compiler(Path(__file__).resolve().parent)
allocating, compiled, inlined = _COMPILER.allocating, _COMPILER.compiled, _COMPILER.inlined
