"""Circuits of the top levels, which show whether an alteration changes anything.

``python -m tools.mutation.tops small FOLDER`` writes each top level of a set as RTLIL, Amaranth's
own netlist; equal texts are equal circuits. A third argument ``verilog`` also writes Verilog, for
:mod:`tools.netlist`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from amaranth.back import rtlil

from pathgene.hdl.boards import find_board
from pathgene.hdl.boards.build import prepare
from pathgene.hdl.config import CheckerBuild, Config, GeneticCore, SurvivorSelection
from pathgene.hdl.top import Chip
from pathgene.hdl.verilog import convert
from tools.chips import SMALL


#: Chips that elaborate in seconds: every build, with sizes at the ends of their ranges.
_SMALL_CHIPS: dict[str, Config] = {
    "small": SMALL,
    "two_tier": SMALL.replace(checker=CheckerBuild.TWO_TIER, lanes=1),
    "parallel": SMALL.replace(checker=CheckerBuild.PARALLEL, lanes=4),
    "by_rank": SMALL.replace(
        elites=1, survivors=3, box_percent=100, survivor_selection=SurvivorSelection.RANK
    ),
}
#: The shipped sizes, and more builds.
_CHIPS: dict[str, Config] = {
    "default": Config(),
    "no_checker": Config(checker=CheckerBuild.NONE, lanes=1),
    "default_two_tier": Config(checker=CheckerBuild.TWO_TIER, lanes=1),
    "check_only": Config(core=GeneticCore.NONE),
    "check_only_two_tier": Config(core=GeneticCore.NONE, checker=CheckerBuild.TWO_TIER, lanes=1),
    "lanes_16": Config(lanes=16),
    "lanes_2": SMALL.replace(checker=CheckerBuild.PARALLEL, lanes=2),
    "lanes_1": SMALL.replace(checker=CheckerBuild.PARALLEL, lanes=1),
    "odd": SMALL.replace(max_waypoints=20, survivors=1, elites=1, children=6, deletes=3),
}
#: One board of each family, with the chip that has the paper core.
_BOARDS = ("ulx3s-85f", "arty-a7-100", "icebreaker")


def _chip(config: Config, stem: Path, verilog_too: bool) -> None:
    text = rtlil.convert(Chip(config), name="chip", emit_src=False)
    stem.with_suffix(".il").write_text(text)
    if verilog_too:
        stem.with_suffix(".v").write_text(convert(Chip(config), "chip"))


def _board(name: str, stem: Path, verilog_too: bool) -> None:
    prepare(find_board(name, "paper"), stem)
    for file in sorted(stem.glob("*.v")):
        stem.with_suffix(".il").write_bytes(file.read_bytes())
        if verilog_too:
            stem.with_suffix(".v").write_bytes(file.read_bytes())


Writer = Callable[[Path, bool], None]


def _writers(chips: dict[str, Config], boards: Sequence[str]) -> dict[str, Writer]:
    writers: dict[str, Writer] = {n: partial(_chip, config) for n, config in chips.items()}
    return writers | {name: partial(_board, name) for name in boards}


#: Top levels by name; the small sets take seconds, the large ones minutes.
SETS = {
    "small": _writers(_SMALL_CHIPS, ()),
    "large": _writers(_CHIPS, ()),
    "boards": _writers({}, _BOARDS),
}


def main(arguments: Sequence[str]) -> int:
    """Write one set to a folder; return the exit status."""
    which, folder, *rest = arguments
    for name, write in SETS[which].items():
        write(Path(folder) / name, rest == ["verilog"])
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
