"""Registers around a unit, so that it can be placed and routed alone."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import InstanceOf, Unit


__all__ = ["Harness"]


class Harness(Unit):
    """Drives every input of a unit from a register, and samples every output in a register.

    The inputs are one long shift register that begins with ``scanned_in``; the outputs are folded
    one after another into ``folded``. A unit with more ports than the device has pins can therefore
    be routed, none of it is optimized away, and all measured paths run from register to register.
    In addition to clock and reset, the harness needs one input pin and one output pin.

    Members
    -------
    scanned_in : In(1)
    folded : Out(1)
    """

    unit: InstanceOf(wiring.Component, "In the domain ``sync``.")
    scanned_in: In(1)
    folded: Out(1)

    def elaborate(self, platform):
        m = Module()

        m.submodules.unit = self.unit
        # Additional registers keep the pins out of the unit's paths.
        bit = Signal()
        m.d.sync += bit.eq(self.scanned_in)
        folded = Signal()
        for path, member, port in self.unit.signature.flatten(self.unit):
            port = Value.cast(port)
            if not len(port):
                continue
            name = "__".join(map(str, path))
            register = Signal(len(port), name=f"register_{name}", reset_less=True)
            if member.flow is In:
                m.d.sync += register.eq(Cat(bit, register))
                m.d.comb += port.eq(register)
                bit = register[-1]
            else:
                m.d.sync += register.eq(port)
                for number, sampled in enumerate(register):
                    passed = Signal(name=f"folded_{name}_{number}", reset_less=True)
                    m.d.sync += passed.eq(folded ^ sampled)
                    folded = passed
        m.d.comb += self.folded.eq(folded)

        return m
