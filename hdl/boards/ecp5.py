"""Options of the tools for every board with an ECP5."""

from collections.abc import Mapping
from types import MappingProxyType


__all__ = ["KEEP_FANOUT", "OVERRIDES", "PLACEMENT", "SYNTHESIS"]

#: Options of ``synth_ecp5``: no multipliers but those of :mod:`hdl.boards.ecp5_multiplier`. For the
#: narrow products of the genetic core, multipliers are slower than logic, and too far from it.
SYNTHESIS = "-nodsp"

#: Commands before synthesis that keep the equal registers of :func:`hdl.primitives.fanout.fanout`
#: apart.
KEEP_FANOUT = "proc; setattr -set keep 1 */a:keep %ci1 t:$dff %i"

#: Options of nextpnr. On the full design, wires are a quarter shorter than with the default placer,
#: and routing terminates.
PLACEMENT = "--placer static"

#: For :class:`hdl.boards.board.Board`.
OVERRIDES: Mapping[str, str] = MappingProxyType(
    {"synth_opts": SYNTHESIS, "script_after_read": KEEP_FANOUT, "nextpnr_opts": PLACEMENT}
)
