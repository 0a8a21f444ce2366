"""Arguments of ``pathgene feasible``."""

from __future__ import annotations

from pathgene.host.cli.arguments.base import Commands, add_command
from pathgene.host.device.checker_modes import MODES


__all__ = ["add_feasible"]


def add_feasible(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "feasible",
        "feasible:run",
        "Check a path against a map with the collision checker of the chip",
        "pathgene feasible --map canyon.npy --path path.csv --board sim: --mode parallel",
        notes="The exit status is 0 for a clear path, 1 for a collision, 2 for bad input.",
    )
    parser.add_argument(
        "--map",
        metavar="FILE",
        required=True,
        help=".npy of integers [y, x], row 0 in the south: altitude steps, where the highest step "
        "marks a no-fly cell; cells outside a smaller map are no-fly",
    )
    parser.add_argument(
        "--path",
        metavar="FILE",
        required=True,
        help="CSV with the header x,y,z of whole cells and altitude steps, the aircraft first, "
        "the goal last",
    )
    parser.add_argument(
        "--board",
        metavar="URL",
        default="model:",
        help="as for pathgene plan; model: and sim: are built for the mode (default %(default)s)",
    )
    parser.add_argument(
        "--mode",
        choices=tuple(MODES),
        help="two-tier: two segments against the detailed map, the others against the coarse map; "
        "detailed: all segments against the detailed map, one cell per cycle; parallel: the same, "
        "several cells per cycle (default the board's; two-tier for model: and sim:)",
    )
    parser.add_argument(
        "--count",
        action="store_true",
        help="walk the whole path and count the colliding cells of each segment, terrain and "
        "no-fly separately",
    )
