"""The problem that the options describe."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from host.cli.arguments.rules import RULES
from host.errors import InputError
from host.evaluation import problem_utopia
from host.problem.aircraft import DEFAULT, Aircraft
from host.problem.aircraft import load as load_aircraft
from host.problem.ends import place
from host.problem.problem import Problem
from host.problem.rules import Rules
from host.problem.zones import Circle, Zone, read_geojson
from host.terrain import Terrain, load
from host.terrain.origin import at_origin


__all__ = [
    "end_point",
    "load_terrain",
    "load_zones",
    "make_problem",
    "placed",
    "rule_arguments",
    "source_of",
]


def load_terrain(args: argparse.Namespace) -> Terrain:
    """Load the terrain of ``--terrain``, ``--fill-voids`` and ``--cell``, at ``--origin``."""
    return placed(args, load(args.terrain, cell=args.cell, fill_voids=args.fill_voids))


def placed(args: argparse.Namespace, terrain: Terrain) -> Terrain:
    """Return the terrain with its south-west node at ``--origin``, if that is given."""
    origin: tuple[float, float] | None = getattr(args, "origin", None)
    return terrain if origin is None else at_origin(terrain, *origin)


def source_of(args: argparse.Namespace) -> dict[str, Any]:
    """Return the origin of the terrain, as a summary states it."""
    path = Path(args.terrain)
    return {
        "source": str(path.resolve()) if path.exists() else args.terrain,
        "fill_voids": args.fill_voids,
        "cell_m": args.cell and list(args.cell),
    }


def load_zones(args: argparse.Namespace, terrain: Terrain) -> tuple[Zone, ...]:
    """Return the no-fly zones of ``--nofly`` and ``--nofly-circle``."""
    files = [zone for file in args.nofly for zone in read_geojson(file, terrain)]
    return (*files, *(Circle(*circle) for circle in args.nofly_circle))


def end_point(
    args: argparse.Namespace,
    name: str,
    terrain: Terrain,
) -> tuple[float, float, float] | None:
    """Return start or goal in local metres, with the third number as given."""
    local: tuple[float, float, float] | None = getattr(args, name)
    if local is not None:
        return local
    geographic = getattr(args, f"{name}_geo")
    if geographic is None:
        return None
    latitude, longitude, altitude = geographic
    return (*place(name, latitude, longitude, terrain), altitude)


def make_problem(args: argparse.Namespace) -> Problem:
    """Return the problem of ``pathgene plan``.

    Raises
    ------
    InputError
        If an option is bad or missing.
    """
    aircraft: Aircraft = load_aircraft(args.uav or DEFAULT)
    terrain = load_terrain(args)
    start, goal = _needed(args, "start", terrain), _needed(args, "goal", terrain)
    problem = Problem(
        terrain,
        start,
        goal,
        aircraft,
        load_zones(args, terrain),
        args.wind or (0.0, 0.0),
        args.ds,
        agl=args.agl,
        **rule_arguments(args),
    )
    # Refuses a start and goal without a finite reference cost, before any work.
    problem_utopia(problem)
    return problem


def rule_arguments(args: argparse.Namespace) -> dict[str, Any]:
    """Return the keywords of :class:`Problem` that the options of the rules give.

    Raises
    ------
    InputError
        If a rule is out of range, or is given with ``--as-paper``.
    """
    given = {name: getattr(args, name) for name in RULES if getattr(args, name) is not None}
    if args.as_paper:
        if given:
            option = next(iter(given)).replace("_", "-")
            raise InputError(
                f"--as-paper has no rules; leave out one of --as-paper and --{option}."
            )
        return {"as_paper": True}
    rules: dict[str, Any] = {
        f"{name}_m": given[name]
        for name in ("clearance", "corridor", "ceiling", "ceiling_agl", "zone_margin")
        if name in given
    }
    if "reserve" in given:
        rules["reserve"] = given["reserve"] / 100
    return {
        "rules": Rules(**rules),
        "start_heading_deg": given.get("start_heading"),
        "goal_heading_deg": given.get("goal_heading"),
    }


def _needed(
    args: argparse.Namespace,
    name: str,
    terrain: Terrain,
) -> tuple[float, float, float]:
    point = end_point(args, name, terrain)
    if point is None:
        raise InputError(f"The {name} is missing; give --{name} or --{name}-geo.")
    return point
