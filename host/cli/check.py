"""``pathgene check``."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.cli.arguments.rules import RULES
from host.cli.output import print_json, print_pairs, term_pairs
from host.cli.problem import end_point, load_terrain, load_zones, rule_arguments, source_of
from host.errors import InputError
from host.planning import check
from host.problem.aircraft import DEFAULT, Aircraft
from host.problem.aircraft import load as load_aircraft
from host.problem.problem import Problem
from host.problem.zones import Zone, zone_from_dict
from host.report.geojson import read_path
from host.report.tables import read_csv
from host.terrain import Terrain


__all__ = ["run"]

# Start and goal from options may differ from those in the file by the rounding of the file.
_SAME_END_M = 0.01


def run(args: argparse.Namespace) -> int:
    """Evaluate the path and print its terms."""
    file = Path(args.path)
    summary = _summary(file)
    if summary is not None:
        _take_options(args, summary, file)
    if args.terrain is None:
        raise InputError("The terrain is missing; give --terrain.")
    terrain = load_terrain(args)
    path = _path(file, summary, terrain)
    problem = Problem(
        terrain,
        tuple(path[0].tolist()),
        tuple(path[-1].tolist()),
        _aircraft(args, summary),
        _zones(args, summary, terrain),
        args.wind or (0.0, 0.0),
        args.ds,
        **rule_arguments(args),
    )
    _check_ends(args, problem)

    report = check(problem, path, source=source_of(args)).report
    if args.json:
        print_json(report)
    else:
        print_pairs(term_pairs(report))
    return 0


def _summary(file: Path) -> dict[str, Any] | None:
    """Return the content of ``file`` if it is a summary."""
    if file.suffix.lower() == ".csv":
        return None
    try:
        document = json.loads(file.read_text("utf-8"))
    except (OSError, ValueError, RecursionError):
        return None  # The reader of the path reports the error.
    is_summary = isinstance(document, dict) and "waypoints" in document
    return document if is_summary else None


def _take_options(args: argparse.Namespace, summary: dict[str, Any], file: Path) -> None:
    """Take missing options from the summary; prefer the grid beside it to its source."""
    try:
        source = summary["terrain"]
        grid = file.with_name("terrain.npz")
        is_grid = args.terrain is None and grid.exists()
        if args.terrain is None:
            args.terrain = str(grid) if is_grid else source["source"]
        if not is_grid:
            args.fill_voids = args.fill_voids or bool(source["fill_voids"])
        if args.cell is None and source["cell_m"] and Path(args.terrain).suffix == ".npy":
            args.cell = tuple(map(float, source["cell_m"]))
        args.wind = args.wind or tuple(map(float, summary["wind"]))
        args.ds = float(summary["ds_m"]) if args.ds is None else args.ds
        _take_rules(args, summary)
    except (KeyError, TypeError, ValueError):
        raise InputError(
            f"{file}: the summary does not say how its path was evaluated; give "
            "--terrain and the other options."
        ) from None


def _take_rules(args: argparse.Namespace, summary: dict[str, Any]) -> None:
    """Take missing rules from the summary; one without rules is as paper."""
    if args.as_paper:
        return
    given = [name for name in RULES if getattr(args, name) is not None]
    if summary.get("as_paper", True):
        args.as_paper = not given
        return
    rules = summary["rules"]
    for name in RULES:
        if name not in given:
            key = f"{name}_deg" if name.endswith("heading") else f"{name}_m"
            value = 100 * rules["reserve"] if name == "reserve" else {**summary, **rules}.get(key)
            setattr(args, name, None if value is None else float(value))


def _path(file: Path, summary: dict[str, Any] | None, terrain: Terrain) -> NDArray[np.float64]:
    if file.suffix.lower() == ".csv":
        return read_csv(file)
    if summary is None:
        return read_path(file, terrain)
    try:
        path = np.array(summary["waypoints"], dtype=np.float64)
    except (TypeError, ValueError):
        path = np.empty(0)
    if path.ndim != 2 or path.shape[1] != 3 or len(path) < 2:
        raise InputError(f"{file}: waypoints must be two or more lists of three numbers.")
    return path


def _aircraft(args: argparse.Namespace, summary: dict[str, Any] | None) -> Aircraft:
    if args.uav is None and summary is not None and "uav" in summary:
        return Aircraft.from_dict(summary["uav"], args.path)
    return load_aircraft(args.uav or DEFAULT)


def _zones(
    args: argparse.Namespace,
    summary: dict[str, Any] | None,
    terrain: Terrain,
) -> tuple[Zone, ...]:
    """Return the zones from the options, or without any, the zones of the summary."""
    given = load_zones(args, terrain)
    if given or summary is None:
        return given
    zones = summary.get("nofly", [])
    if not isinstance(zones, list):
        raise InputError(f"{args.path}: nofly must be a list of zones, not {zones!r}.")
    return tuple(zone_from_dict(zone) for zone in zones)


def _check_ends(args: argparse.Namespace, problem: Problem) -> None:
    """Refuse a start or goal that differs from the path's end."""
    for name in ("start", "goal"):
        given = end_point(args, name, problem.terrain)
        if given is None:
            continue
        own = getattr(problem, name)
        if args.agl:
            x, y, height_m = given
            given = x, y, problem.terrain.ground(x, y) + height_m
        if not np.allclose(given, own, rtol=0, atol=_SAME_END_M):
            raise InputError(f"The {name} of the path is {own}, not {given}; leave --{name} out.")
