"""The compiler of these kernels; each may be made of the sources of this package."""

from pathlib import Path

from pathgene.jit import Compiler


__all__ = ["compiled", "inlined"]

_COMPILER = Compiler(Path(__file__).resolve().parent)
compiled, inlined = _COMPILER.compiled, _COMPILER.inlined
