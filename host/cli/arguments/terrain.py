"""Arguments of ``pathgene terrain``."""

from __future__ import annotations

from pathgene.host.cli.arguments.base import Commands, add_command, add_command_group, cell_sides


__all__ = ["add_terrain"]


def add_terrain(commands: Commands) -> None:
    """Add the command and its commands."""
    actions = add_command_group(
        commands, "terrain", "List, describe and make terrains", "pathgene terrain info tile.tif"
    )
    add_command(
        actions,
        "list",
        "terrain:list_embedded",
        "List the embedded terrains",
        "pathgene terrain list --json",
    )
    info = add_command(
        actions,
        "info",
        "terrain:info",
        "Describe a terrain",
        "pathgene terrain info tile.tif --fill-voids",
    )
    info.add_argument("terrain", metavar="FILE|NAME", help="as --terrain of pathgene plan")
    info.add_argument("--fill-voids", action="store_true", help="interpolate cells without data")
    info.add_argument(
        "--max-cells",
        type=int,
        metavar="N",
        help="most cells of a terrain that is read (default 25 million)",
    )
    info.add_argument(
        "--cell",
        type=cell_sides,
        metavar="DX[,DY]",
        help="sides of a cell of a .npy terrain in metres",
    )
    synth = add_command(
        actions,
        "synth",
        "terrain:synth",
        "Make a synthetic terrain",
        "pathgene terrain synth canyon --seed 3 --out canyon3.npz",
    )
    synth.add_argument(
        "kind",
        metavar="KIND",
        choices=("canyon", "river", "large-canyon"),
        help="canyon, river or large-canyon",
    )
    synth.add_argument(
        "--seed",
        type=int,
        metavar="N",
        default=0,
        help="seed of the terrain; the same seed gives the same terrain (default %(default)s)",
    )
    synth.add_argument("--out", metavar="FILE", required=True, help=".npz file to write")
