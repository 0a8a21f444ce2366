"""Options of the tools for every board with an ECP5."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType


__all__ = ["ARITHMETIC", "KEEP_FANOUT", "OVERRIDES", "PLACEMENT", "PLANNER_OVERRIDES", "SYNTHESIS"]

#: Options of ``synth_ecp5``: no multipliers except the ones of
#: :mod:`pathgene.hdl.boards.ecp5_multiplier`. For the narrow products of the genetic core,
#: multipliers are slower than logic, and too far from it.
SYNTHESIS = "-nodsp"

#: Commands before synthesis that keep the equal registers of
#: :func:`pathgene.hdl.primitives.fanout.fanout` apart.
KEEP_FANOUT = "proc; setattr -set keep 1 */a:keep %ci1 t:$dff %i"

#: Options of nextpnr. On the full design, wires are a quarter shorter than with the default placer,
#: and routing terminates.
PLACEMENT = "--placer static"

#: For :class:`pathgene.hdl.boards.board.Board`.
OVERRIDES: Mapping[str, str] = MappingProxyType(
    {"synth_opts": SYNTHESIS, "script_after_read": KEEP_FANOUT, "nextpnr_opts": PLACEMENT}
)

#: File of maps for arithmetic; each says what it is for.
ARITHMETIC = Path(__file__).with_name("ecp5_arithmetic.v")

#: The same for a chip with a planner, with carry chains by :data:`ARITHMETIC`. Its maps do their
#: part before synthesis, where synthesis would map carry chains, and at its end.
PLANNER_OVERRIDES: Mapping[str, str] = MappingProxyType(
    {
        **OVERRIDES,
        "script_after_read": "\n".join(
            [
                KEEP_FANOUT,
                "design -stash chip",
                "read_verilog -nooverwrite -noblackbox -icells <<EOT",
                ARITHMETIC.read_text(encoding="utf-8"),
                "EOT",
                "design -stash arithmetic",
                "design -load chip",
                "techmap -map %arithmetic t:ADD_OR_SUBTRACT",
                f"synth_ecp5 {SYNTHESIS} -run begin:map_gates",
                "techmap -map %arithmetic t:$alu",
            ]
        ),
        "synth_opts": f"{SYNTHESIS} -run map_gates:blif",
        "script_after_synth": "techmap -map %arithmetic t:CCU2C",
    }
)
