"""``pathgene feasible``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from pathgene.host.cli.arguments import Commands, add_command
from pathgene.host.cli.output import note_start, print_json
from pathgene.host.device.checker_modes import MODES
from pathgene.host.errors import JobError
from pathgene.host.planners import DEFAULT_BOARD


if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from pathgene.hdl.config import Config
    from pathgene.host.device.paths import CheckReport


__all__ = ["add", "run"]


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "feasible",
        run,
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
        default=DEFAULT_BOARD,
        help="as for pathgene plan; model: and sim: are built for the mode (default %(default)s)",
    )
    parser.add_argument(
        "--mode",
        choices=tuple(MODES),
        help="two-tier: two segments against the detailed map, all further ones against the "
        "coarse map; detailed: all segments against the detailed map, one cell per cycle; "
        "parallel: the same, several cells per cycle (default the board's; two-tier for model: "
        "and sim:)",
    )
    parser.add_argument(
        "--count",
        action="store_true",
        help="walk the whole path and count the colliding cells of each segment, terrain and "
        "no-fly separately",
    )


def run(args: argparse.Namespace) -> int:
    """Check a path on a board and print its verdict; a collision is a failure."""
    note_start("Reading the map.")
    from pathgene.host.device.boards import open_board
    from pathgene.host.device.checker_boards import order_board, require_checker
    from pathgene.host.device.paths import pack_waypoints

    url, config = order_board(args.board, args.mode)
    # Read the files first: building a board may take a minute.
    files = _read(args, config) if config is not None else None
    with open_board(url) as chip:
        require_checker(chip.config, args.mode, args.board)
        heights, points = files or _read(args, chip.config)
        rows, columns = _walked(points, chip.config)
        chip.upload_map(
            heights[rows, columns], columns.start, rows.start, progress=_shown_on(sys.stderr)
        )
        checked = chip.check_path(pack_waypoints(chip.config, points), counting=args.count)
    report = _report(checked)
    if args.count:
        report["colliding"] = _colliding(checked, segments=len(points) - 1)
    if args.json:
        print_json(report)
    else:
        print(json.dumps(report))
    if report["collision"]:
        x, y = report["cell"]
        raise JobError(f"The path collides on segment {report['segment']}, in cell ({x}, {y}).")
    return 0


def _read(args: argparse.Namespace, config: Config) -> tuple[NDArray[np.uint16], NDArray[np.int64]]:
    from pathgene.host.cli.feasible_files import read_map, read_points

    return read_map(Path(args.map), config), read_points(Path(args.path), config)


def _walked(points: NDArray[np.int64], config: Config) -> tuple[slice, slice]:
    """Return the rows and columns of the map that the check of a path may read.

    Every cell of a segment lies in the rectangle of its ends. The coarse map summarizes whole
    blocks, so the rectangle of all points grows to the edges of blocks.
    """
    block = config.coarse_factor
    first = points[:, :2].min(axis=0) // block * block
    last = (points[:, :2].max(axis=0) // block + 1) * block
    (west, south), (east, north) = first.tolist(), last.tolist()
    return slice(south, north), slice(west, east)


def _shown_on(stream: TextIO) -> Callable[[int, int], None] | None:
    """Return a progress bar for the upload if ``stream`` is a terminal."""
    if not stream.isatty():
        return None

    def show(done: int, cells: int) -> None:
        stream.write(f"\r\x1b[Kmap {100 * done // cells} %" + "\n" * (done == cells))
        stream.flush()

    return show


def _report(checked: CheckReport) -> dict[str, Any]:
    verdict = checked.verdicts[0]
    hit = verdict.collision
    return {
        "collision": hit,
        "over": not hit,
        "segment": verdict.segment,
        "cell": list(verdict.cell) if verdict.cell is not None else None,
        "map": ("coarse" if verdict.coarse else "detailed") if hit else None,
        "cells": checked.cells,
        "reads": checked.reads,
        "cycles": checked.cycles,
    }


def _colliding(checked: CheckReport, segments: int) -> list[list[int]]:
    """Return the colliding cells of each segment, terrain and no-fly separately."""
    counts = [[0, 0] for _ in range(segments)]
    for segment, terrain, nofly in checked.verdicts[0].entries:
        counts[segment] = [terrain, nofly]
    return counts
