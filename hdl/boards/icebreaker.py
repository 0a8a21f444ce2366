"""1BitSquared iCEBreaker with an iCE40 UP5K: the two-tier checker alone, its map in SPRAM."""

from amaranth.build import Attrs, Pins, Resource
from amaranth_boards.icebreaker import ICEBreakerPlatform

from pathgene.hdl.boards.board import Board
from pathgene.hdl.boards.pll import Ice40Pll
from pathgene.hdl.config import CheckerBuild, Config


__all__ = ["CHIPS"]


class _Platform(ICEBreakerPlatform):
    """Platform with the first button of the break-off PMOD, high when pressed."""

    resources = [
        *ICEBreakerPlatform.resources,
        Resource(
            "reset_pin",
            0,
            Pins("9", dir="i", conn=("pmod", 2)),
            Attrs(IO_STANDARD="SB_LVCMOS"),
        ),
    ]


_PAPER = Board(
    name="icebreaker",
    platform=_Platform,
    # 12 MHz to 24 MHz; its USB bridge is an FT2232H.
    pll=Ice40Pll(divf=63, divq=5),
    reset=("reset_pin", 0),
    sizes=Config(core="none", checker=CheckerBuild.TWO_TIER, lanes=1, map_size=256),
    overrides={"synth_opts": "-device u -spram -dsp"},
)

# A planner would need twice the logic and ten times the multipliers of the device.
CHIPS = (_PAPER,)
