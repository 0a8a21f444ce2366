"""Results, options and documents of the command line."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import inspect
import io
import itertools
import json
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.scenarios import problem
from pathgene.hdl.config import Config
from pathgene.host.cli import main
from pathgene.host.cli.parser import build_parser
from pathgene.host.planners import PLANNERS, make


__all__ = ["MAPS", "describe_options", "plan", "record_keys", "record_options", "record_plans"]

#: Embedded terrains.
MAPS = ("jacksboro", "canyon", "river")
_SEEDS = (1, 2, 3)
#: Generations per planner: a few minutes on one core in all.
_GENERATIONS = {
    "ga-fpga": 150,
    "ga-pc": 150,
    "astar": 8,
    "fpa": 150,
    "fpa-2opt": 100,
    "ga-dp": 30,
    "ga-auv": 60,
}
_FEW = 3
#: Further options, each tried on one map with one seed.
_VARIANTS: dict[str, list[tuple[str, ...]]] = {
    "ga-fpga": [
        ("--link-mode", "population"),
        ("--link-mode", "recipe"),
        ("--feasibility", "board"),
        ("--initial-draws", "1"),
        ("--board", "model:?max_waypoints=20&survivor_selection=rank"),
    ],
    "ga-pc": [("--max-waypoints", "8"), ("--refits", "1"), ("--population", "20")],
    "astar": [("--max-waypoints", "5")],
    "fpa": [("--engine", "sequential"), ("--waypoints", "9")],
    "fpa-2opt": [("--two-opt-every", "5")],
    "ga-dp": [("--reading", "sum"), ("--draws", "uniform"), ("--added-points", "4")],
    "ga-auv": [("--draws", "uniform")],
}
_AUV = [
    ("--landscape", "1", "--planner", "ga-dp"),
    ("--landscape", "2", "--planner", "ga-dp", "--length", "3d", "--reading", "sum"),
    ("--landscape", "1", "--planner", "ga-auv"),
    ("--landscape", "2", "--planner", "ga-auv", "--draws", "uniform"),
]
#: Keys of a summary whose values depend on the run or the release.
_PASSING = ("seconds", "pathgene")


def run(*arguments: str) -> tuple[int, Any]:
    """Run a command in this process; return its exit status and the JSON that it printed."""
    output = io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(io.StringIO()) as errors:
        status = main(arguments)
    if not output.getvalue():
        raise RuntimeError(f"pathgene {' '.join(arguments)}: {errors.getvalue().strip()}")
    return status, json.loads(output.getvalue())


def _ends(name: str) -> list[str]:
    """Return the options of the benchmarks' scenario on a map, floats exact."""
    scenario = problem(name)
    options = ["--as-paper", "--terrain", name]
    for end in ("start", "goal"):
        options += [f"--{end}", ",".join(map(repr, getattr(scenario, end)))]
    for zone in scenario.zones:
        circle = map(repr, zone.to_dict().values())
        options += ["--nofly-circle", ",".join(circle)]
    return options


def plan(name: str, planner: str, *options: str) -> tuple[int, dict[str, Any], list[str]]:
    """Plan on a map; return the exit status, the whole summary and the files written."""
    with tempfile.TemporaryDirectory() as folder:
        status, summary = run(
            "plan", *_ends(name), "--planner", planner, *options, "--json", "--out", folder
        )
        return status, summary, sorted(file.name for file in Path(folder).iterdir())


def record_plans() -> dict[str, Any]:
    """Return exit status and summary, times left out, of every planner on every map."""
    found: dict[str, Any] = {}
    for planner, name, seed, options in _runs():
        words = ("--generations", str(_GENERATIONS[planner]), "--seed", str(seed), *options)
        status, summary, files = plan(name, planner, *words)
        title = " ".join((planner, *options, f"on {name}, seed {seed}"))
        found[title] = {"status": status, "files": files, **_lasting(summary)}
    paper = "--as-paper", "--generations", "20", "--seed", "1", "--json"
    for words in _AUV:
        with tempfile.TemporaryDirectory() as folder:
            status, summary = run("auv", *words, *paper, "--out", folder)
        found[" ".join(("auv", *words))] = {"status": status, **_lasting(summary)}
    return found


def _runs() -> Iterator[tuple[str, str, int, tuple[str, ...]]]:
    """Yield planner, map, seed and further options of every run."""
    for planner, entry in PLANNERS.items():
        for options in _starts(entry.options):
            for name, seed in itertools.product(MAPS, _SEEDS):
                yield planner, name, seed, options
        for options in _VARIANTS[planner]:
            yield planner, MAPS[1], _SEEDS[0], options


def _starts(known: Sequence[str]) -> list[tuple[str, ...]]:
    """Yield the options for each start of the search of a planner with the options ``known``."""
    return [(), ("--init", "astar")] if "init" in known else [()]


def _lasting(summary: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in summary.items() if key not in _PASSING}


def record_options() -> dict[str, Any]:
    """Return name, default and choices of every option, of planners and chip, too."""
    _, planners = run("planners", "--json")
    return {
        **dict(describe_options(build_parser())),
        "planners": {
            entry["name"]: {
                "generations": entry["generations"],
                "engines": entry["engines"],
                "options": _defaults(entry["name"], entry["options"]),
            }
            for entry in planners
        },
        "chip": dataclasses.asdict(Config()),
        "build": Config().build_id,
    }


def _defaults(planner: str, options: Iterable[str]) -> dict[str, Any]:
    """Return the defaults of a planner's own options, which the parser does not know."""
    parameters = inspect.signature(type(make(planner))).parameters
    return {name: parameters[name].default for name in options}


def describe_options(parser: argparse.ArgumentParser) -> Iterator[tuple[str, Any]]:
    """Yield each command with options, and the properties of its options except the prose."""
    rows = {}
    # If a problem file may supply an option, its default is recorded separately.
    defaults = parser.get_default("option_defaults") or {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from describe_options(command)
        else:
            rows[", ".join(action.option_strings) or action.dest] = {
                "dest": action.dest,
                "number": action.type.__name__ if action.type in (int, float) else None,
                "default": defaults.get(action.dest, action.default),
                "const": action.const,
                "choices": action.choices and list(action.choices),
                "nargs": action.nargs,
                "required": action.required,
                "kind": type(action).__name__,
            }
    groups = [
        [action.dest for action in group._group_actions]
        for group in parser._mutually_exclusive_groups
    ]
    yield parser.prog, {"options": rows, "exclusive": groups}


def record_keys() -> dict[str, list[str]]:
    """Return the keys of every JSON document that a command prints."""
    name = MAPS[1]
    few = ("--generations", str(_FEW))
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        out = ("--json", "--out", folder)
        for planner, entry in PLANNERS.items():
            variants = _starts(entry.options)
            variants += [("--feasibility", "board")] if "feasibility" in entry.options else []
            for options in variants:
                words = ("plan", *_ends(name), "--planner", planner, *few, *options, *out)
                found[" ".join((planner, *options))] = run(*words)[1]
        found["check"] = run("check", "--path", f"{folder}/summary.json", "--json")[1]
        found["auv"] = run("auv", *few, *out)[1]
        found["compare"] = run(
            "compare",
            *_ends(name),
            "--planners",
            "ga-pc,astar",
            "--runs",
            "2",
            "--jobs",
            "1",
            *few,
            *out,
        )[1]
        heights, path = Path(folder, "map.npy"), Path(folder, "path.csv")
        np.save(heights, np.eye(8, dtype=np.int64))
        path.write_text("x,y,z\n0,0,9\n3,5,1\n7,7,0\n")
        given = ("feasible", "--map", str(heights), "--path", str(path), "--json")
        found["feasible"] = run(*given)[1]
        found["feasible --count"] = run(*given, "--count")[1]
    for command in ("board info", "terrain list", f"terrain info {name}", "planners"):
        found[command] = run(*command.split(), "--json")[1]
    return {title: sorted(set(_keys(document))) for title, document in found.items()}


def _keys(value: Any, path: str = "") -> Iterator[str]:
    if isinstance(value, dict):
        for key, item in value.items():
            yield f"{path}.{key}"
            yield from _keys(item, f"{path}.{key}")
    elif isinstance(value, list):
        for item in value:
            yield from _keys(item, f"{path}[]")
