"""Paper core with its control unit: a top level for simulation and other chips."""

from amaranth import *
from amaranth.lib.wiring import Out, connect

from pathgene.hdl.config import Config
from pathgene.hdl.control import Control
from pathgene.hdl.ga_core.core import PaperCore
from pathgene.hdl.primitives.unit import InstanceOf, Unit


__all__ = ["PaperCoreTop"]


class PaperCoreTop(Unit):
    """Paper core with the chip's control unit, without link, command units and checker.

    The surrounding logic must receive commands, check paths and answer: see
    :class:`pathgene.hdl.control.Control`.

    Members
    -------
    ...
        The members of :class:`pathgene.hdl.ga_core.core.PaperCore` and
        :class:`pathgene.hdl.control.Control`, except the two that connect them.
    ranked : Out(1)
        A whole ranking is processed, so a generation may start.
    """

    config: InstanceOf(Config)

    def interface(self):
        config = self.config
        if not config.paper_core:
            raise ValueError(f"Config.core must be paper for the paper core, not {config.core}")
        self._control = Control(config)
        self._core = PaperCore(config)
        return {"ranked": Out(1)} | {
            name: member
            for unit in (self._control, self._core)
            for name, member in unit.signature.members.items()
            if name not in ("control", "core")
        }

    def elaborate(self, platform):
        m = Module()

        m.submodules.control = control = self._control
        m.submodules.core = core = self._core
        connect(m, control.core, core.control)
        m.d.comb += self.ranked.eq(core.control.ready)

        # All remaining ports of the two are ports of the top level.
        outer = {path: port for path, _, port in self.signature.flatten(self)}
        for unit in (control, core):
            for path, member, port in unit.signature.flatten(unit):
                if path not in outer:
                    continue
                if member.flow is Out:
                    m.d.comb += outer[path].eq(port)
                else:
                    m.d.comb += port.eq(outer[path])

        return m
