"""What the tools are told for every board with an ECP5."""

from collections.abc import Mapping
from types import MappingProxyType


__all__ = ["KEEP_FANOUT", "OVERRIDES", "PLACEMENT", "SYNTHESIS"]

#: Options of ``synth_ecp5``: no multipliers but those of :mod:`hdl.boards.ecp5_multiplier`. Those
#: that it would take for the narrow products of the genetic core are slower than logic, and too far
#: from it.
SYNTHESIS = "-nodsp"

#: Commands before synthesis, which would make one register of :func:`hdl.primitives.fanout.fanout`
#: again.
KEEP_FANOUT = "proc; setattr -set keep 1 */a:keep %ci1 t:$dff %i"

#: Options of nextpnr. On the full design the wires are a quarter shorter than with its default
#: placer, and the router comes to an end.
PLACEMENT = "--placer static"

#: For :class:`hdl.boards.board.Board`.
OVERRIDES: Mapping[str, str] = MappingProxyType(
    {"synth_opts": SYNTHESIS, "script_after_read": KEEP_FANOUT, "nextpnr_opts": PLACEMENT}
)
