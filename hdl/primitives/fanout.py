"""Equal registers, each for a part of the chip."""

from amaranth import *


__all__ = ["fanout"]


def fanout(m: Module, *values: Value, name: str, init: int = 0) -> list[Signal]:
    """Return a register of the domain ``sync`` for each of ``values``, which are all equal.

    A wire across the chip takes a cycle, and a register that drives a thousand registers lies far
    from most of them; a copy can lie among its loads. The attribute ``keep`` of the copies is for a
    board's synthesis, which would merge them again.
    """
    registers = [
        Signal(len(value), name=f"{name}_{number}", init=init, attrs={"keep": 1})
        for number, value in enumerate(values)
    ]
    m.d.sync += [register.eq(value) for register, value in zip(registers, values, strict=True)]
    return registers
