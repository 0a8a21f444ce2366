"""Genetic core with its control unit: a top of its own, for simulation and other chips."""

from types import SimpleNamespace

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import Out, connect, flipped

from hdl.config import Config
from hdl.control import Control
from hdl.ga_core.core import Core


__all__ = ["GeneticCoreTop"]


class GeneticCoreTop(wiring.Component):
    """Genetic core under the control unit of the chip, without link, command units and checker.

    Whoever uses it receives commands, checks paths and answers in their place: see
    :class:`hdl.control.Control`.

    Parameters
    ----------
    config : Config
        Of a chip with a genetic core.

    Members
    -------
    ...
        Those of :class:`hdl.ga_core.core.Core` and of :class:`hdl.control.Control`, but for those
        that connect these two.
    ranked : Out(1)
        A whole ranking has been worked in: a generation may start.

    Raises
    ------
    TypeError
        If ``config`` is not a Config.
    ValueError
        If its chip has no genetic core.
    """

    def __init__(self, config: Config):
        if not isinstance(config, Config):
            raise TypeError(f"Config must be a Config, not {config!r}")
        if not config.genetic:
            raise ValueError("Config.genetic must be 1 for a genetic core, not 0")

        self.config = config
        self._control = Control(config)
        self._core = Core(config)
        self._outer = {
            self._control: self._control.signature.members.keys() - {"core"},
            self._core: self._core.signature.members.keys() - {"control"},
        }
        super().__init__(
            {"ranked": Out(1)}
            | {
                name: unit.signature.members[name]
                for unit, names in self._outer.items()
                for name in unit.signature.members
                if name in names
            }
        )

    def elaborate(self, platform):
        m = Module()

        m.submodules.control = control = self._control
        m.submodules.core = core = self._core
        connect(m, control.core, core.control)
        m.d.comb += self.ranked.eq(core.control.ready)
        for unit, names in self._outer.items():
            connect(m, _part(flipped(self), names), _part(unit, names))

        return m


def _part(interface, names):
    """Return an interface object with some of the members of another."""
    members = {name: interface.signature.members[name] for name in names}
    return SimpleNamespace(
        signature=wiring.Signature(members), **{name: getattr(interface, name) for name in names}
    )
