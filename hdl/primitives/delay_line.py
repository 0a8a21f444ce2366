"""Registers in a row."""

from amaranth import *


__all__ = ["delayed"]


def delayed(m: Module, value: Value, clocks: int, name: str) -> Value:
    """Return ``value`` of ``clocks`` clocks ago, through registers without reset.

    A value without bits stays what it is: Verilog has no such registers.
    """
    if Shape.cast(value.shape()).width == 0:
        return value
    for clock in range(1, clocks + 1):
        earlier = Signal(value.shape(), name=f"{name}_{clock}", reset_less=True)
        m.d.sync += earlier.eq(value)
        value = earlier
    return value
