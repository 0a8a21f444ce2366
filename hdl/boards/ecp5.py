"""Options of the tools for every board with an ECP5, and the floor plan of an LFE5U-85F.

A map takes nearly all block RAMs. By default, the placer spreads the block RAMs of a bank over the
whole die, although each row address has to reach all of them, and puts the remaining block RAMs on
leftover sites; it lines the multipliers up along the whole width of the die. The planner core's own
units lie in the middle of the die: its map leaves the block RAMs there free, and the placer assigns
them.
"""

import json
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from types import MappingProxyType

from pathgene.hdl.config import Config


__all__ = [
    "ARITHMETIC",
    "KEEP_FANOUT",
    "MAP_SITES",
    "OTHER_SITES",
    "OVERRIDES",
    "PLACEMENT",
    "PLANNER_FLOOR_PLAN",
    "PLANNER_MAP_SITES",
    "PLANNER_OVERRIDES",
    "SYNTHESIS",
    "floor_plan",
]


#: Options of ``synth_ecp5``: no multipliers except the ones of
#: :mod:`pathgene.hdl.boards.ecp5_cells`. For the narrow products of the paper core, multipliers
#: are slower than logic and too far away.
SYNTHESIS = "-nodsp"

#: Commands before synthesis that keep the equal registers of
#: :func:`pathgene.hdl.primitives.logic.fanout` apart.
KEEP_FANOUT = "proc; setattr -set keep 1 */a:keep %ci1 t:$dff %i"

#: Options of nextpnr. On the full design, wires are a quarter shorter than with the default placer,
#: and routing terminates.
PLACEMENT = "--placer static"

#: For :class:`pathgene.hdl.boards.board.Board`.
OVERRIDES: Mapping[str, str] = MappingProxyType(
    {"synth_opts": SYNTHESIS, "script_after_read": KEEP_FANOUT, "nextpnr_opts": PLACEMENT}
)

#: File with technology maps for arithmetic; each map states its purpose.
ARITHMETIC = Path(__file__).with_name("ecp5_arithmetic.v")

#: The same for a chip with a planner, with carry chains from :data:`ARITHMETIC`. Its maps are
#: applied before synthesis would map carry chains, and again at the end.
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


#: First columns of the groups of four block RAMs or multipliers in a row.
_GROUPS = (*range(4, 59, 9), *range(69, 115, 9))


def _strips() -> tuple[list[str], list[str]]:
    """Return the sites for a map, with neighbours in sequence, and the remaining sites.

    The die is 126 tiles wide and 95 high. It has four rows of 13 groups of four block RAMs, each of
    which forms four strips of 13; the block RAM in the middle of a strip remains. A quadrant of the
    die has four strips in sequence.
    """
    columns = [(x + 2 * number, number) for x in _GROUPS for number in range(4)]
    taken, left = [], []
    for rows in ((22, 46), (70, 82)):
        for half in (0, 26):
            for y in rows:
                for strip in (half, half + 13):
                    sites = [f"X{x}/Y{y}/EBR{number}" for x, number in columns[strip:][:13]]
                    left.append(sites.pop(6))
                    taken += sites
    return taken, left


_TAKEN, _LEFT = _strips()

#: Sites in the order in which the blocks of a map take them.
MAP_SITES = tuple(_TAKEN)


def _ring() -> list[str]:
    """Return all sites, starting around the middle of the die, with neighbours in sequence.

    A quadrant has 44 of these, which blocks of 4 or 11 fill without gaps. The 32 in the middle are
    16 in each inner row.
    """
    columns = [(x + 2 * number, number) for x in _GROUPS for number in range(4)]
    around, middle = [], []
    for outer, inner in ((22, 46), (82, 70)):
        for half in (columns[:26], columns[:25:-1]):
            left, free = half[:18], half[18:]
            strip = [*((outer, *site) for site in half), *((inner, *site) for site in left[::-1])]
            around += [f"X{x}/Y{y}/EBR{number}" for y, x, number in strip]
            middle += [f"X{x}/Y{inner}/EBR{number}" for x, number in free]
    return [*around, *middle]


#: Sites in the order in which the blocks of a planner's map take them.
PLANNER_MAP_SITES = tuple(_ring())

#: Sites of the remaining block RAMs by cell name: the link's at the edge near its pins, the
#: checker's in the middle.
OTHER_SITES: Mapping[str, str] = MappingProxyType(
    {
        "line.frame_receiver.ring.rows.0.0": "X17/Y46/EBR2",
        "line.frame_transmitter.encoder.ring.rows.0.0": "X17/Y70/EBR2",
        "check_controller.source.ring.rows.0.0": "X46/Y46/EBR3",
        "checker.walker.setup.reciprocals.table.0.0": "X46/Y70/EBR3",
        "checker.walker.setup.reciprocals.table.0.1": "X46/Y82/EBR3",
        "check_controller.store.entry_rows.0.0": "X78/Y46/EBR0",
        "check_controller.store.entry_rows.0.1": "X78/Y70/EBR0",
    }
)
assert set(OTHER_SITES.values()) <= set(_LEFT)

#: Sites of the link's block RAMs on a chip with a planner: at the end of the middle region that is
#: nearest to its pins. The placer would put them anywhere.
_PLANNER_SITES: Mapping[str, str] = MappingProxyType(
    {
        "line.frame_receiver.ring.rows.0.0": "X44/Y46/EBR2",
        "line.frame_transmitter.encoder.ring.rows.0.0": "X44/Y70/EBR2",
    }
)

#: Column around which the multipliers are placed.
_MIDDLE = 54


def _multipliers(lanes: int) -> Iterator[tuple[str, str]]:
    """Yield the multipliers of the slopes with their sites, a group for each lane."""
    # Starting at the middle of the die, in both rows of multipliers.
    groups = sorted(product(_GROUPS, (34, 58)), key=lambda group: abs(group[0] - _MIDDLE))
    for (x, y), of in zip(groups, ["step", *map(str, range(lanes))], strict=False):
        offsets = (0, 1, 4, 5)
        kinds = product(("minor", "rise"), ("low", "high"))
        for offset, (axis, part) in zip(offsets, kinds, strict=True):
            name = f"checker.walker.slopes.{axis}_{of}_{part}.hard.primitive"
            yield name, f"X{x + offset}/Y{y}/MULT18_{offset}"


def floor_plan(config: Config) -> str:
    """Return Yosys commands that put all cells except the map's on their sites after synthesis.

    The commands fail if a cell is missing.

    Parameters
    ----------
    config : Config
        Configuration of the chip: the default one with any number of lanes.

    Raises
    ------
    ValueError
        If ``config`` is any other configuration.
    """
    if config != Config(lanes=config.lanes):
        raise ValueError(
            "Floor plan must belong to the default configuration with any lanes; a board with "
            "another one can leave `script_after_synth` out"
        )
    return _commands({**OTHER_SITES, **dict(_multipliers(config.lanes))})


def _commands(sites: Mapping[str, str]) -> str:
    lines = []
    for name, site in sites.items():
        cell = f"c:planner.{name}"
        lines += [f"select -assert-count 1 {cell}", f"setattr -set BEL {json.dumps(site)} {cell}"]
    return "\n".join(lines)


#: The same for a chip with a planner, whose map leaves the middle of the die free.
PLANNER_FLOOR_PLAN = _commands(_PLANNER_SITES)
