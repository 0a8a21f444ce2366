"""The compiler of the kernels of the model, which share numbers with the gateware."""

from pathlib import Path

from pathgene.jit import Compiler


__all__ = ["allocating", "compiled", "inlined"]

_HDL = Path(__file__).resolve().parents[2] / "hdl"
_COMPILER = Compiler(_HDL, _HDL / "protocol")
allocating, compiled, inlined = _COMPILER.allocating, _COMPILER.compiled, _COMPILER.inlined
