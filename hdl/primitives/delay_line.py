"""Registers in a row."""

from amaranth import *


__all__ = ["delay_line"]


def delay_line(m: Module, value: Value, cycles: int, name: str) -> Value:
    """Return ``value`` of ``cycles`` cycles ago, through registers without reset.

    A value without bits is returned as it is: Verilog has no registers of that width.
    """
    if Shape.cast(value.shape()).width == 0:
        return value
    for cycle in range(1, cycles + 1):
        earlier = Signal(value.shape(), name=f"{name}_{cycle}", reset_less=True)
        m.d.sync += earlier.eq(value)
        value = earlier
    return value
