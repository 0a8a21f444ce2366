"""Bad options of the command line: numbers, unknown and contradictory options, URLs of boards."""

import argparse
import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from pathgene.host.cli.parser import build_parser
from tests.support.bad_input.judge import is_number


@dataclass(frozen=True)
class Case:
    """A command line with the files of its folder.

    Parameters
    ----------
    kind : str
        Name of the fault, in a word.
    arguments : tuple of str
        The arguments of ``pathgene``.
    files : mapping of str to bytes
        Content of the files by name.
    surely_bad : bool
        It must be refused. Otherwise the damage may have hit bytes that nobody reads, so that a
        success or a failed job is also right.
    """

    kind: str
    arguments: tuple[str, ...]
    files: Mapping[str, bytes] = field(default_factory=dict)
    surely_bad: bool = False


LAND = "../base/land.npz"
CHECK = ("check", "--terrain", LAND, "--path", "../base/path.csv")
_ENDS = ("--terrain", LAND, "--start", "150,150,600", "--goal", "1550,1550,600")
# No folder can be created there, so with a good value the command ends with that error before its
# work.
_NOWHERE = ("--out", "../base/path.csv/out")

#: A good command line of each command that has numbers.
_GOOD: Mapping[str, tuple[str, ...]] = {
    "plan": ("plan", *_ENDS, *_NOWHERE),
    "check": CHECK,
    "compare": ("compare", *_ENDS, "--planners", "ga-pc", *_NOWHERE),
    "diagnose": ("diagnose", *_ENDS, "--out", "out"),
    "batch": ("batch", "../base/problem.toml", *_NOWHERE),
    "fly": ("fly", "../base/summary.json", *_NOWHERE),
    "export": ("export", "../base/summary.json", *_NOWHERE),
    "upload": ("upload", "../base/summary.json", "--to", "udpout:127.0.0.1:9", "--timeout", "0.01"),
    "auv": ("auv", *_NOWHERE),
    "terrain info": ("terrain", "info", LAND),
    "terrain synth": ("terrain", "synth", "canyon", "--out", "../base/path.csv/x.npz"),
}

# More digits than a C int, a float or a Python int may have.
_LONG = "9" * 10, "9" * 400, "9" * 5000

#: Texts instead of numbers.
NUMBERS = (
    "nan", "inf", "-inf", "-0", "0", "-1", "1e308", "-1e308", "1e-320", "9" * 400, "-" + "9" * 400,
    "9" * 5000, "--", "", " ", "x", "0x10", "1_000", "1e400", "\u0661\u0662", "\u00b2", "\uff11",
    "1,5", "1;5", "5 m", "\udcff", "2147483648", "18446744073709551616", "1e-9", "-2147483649",
)  # fmt: skip


def numeric_options() -> Iterator[tuple[str, str, int]]:
    """Yield each command with each of its numeric options and the count of numbers it takes."""
    for command in _GOOD:
        parser: argparse.ArgumentParser = build_parser()
        for word in command.split():
            (sub,) = (a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
            parser = sub.choices[word]
        for action in parser._actions:
            if action.option_strings and action.type not in (None, str):
                count = str(action.metavar).count(",") + 1
                yield command, action.option_strings[0], count


_NUMERIC = tuple(numeric_options())


def number(rng: random.Random) -> Case:
    """An odd number for one of the options that take numbers."""
    command, option_name, count = rng.choice(_NUMERIC)
    parts = rng.choices(("10", rng.choice(NUMBERS), rng.choice(NUMBERS)), k=count)
    parts[rng.randrange(count)] = rng.choice(NUMBERS)
    text = ",".join(parts)
    given = (f"{option_name}={text}",) if rng.random() < 0.5 else (option_name, text)
    # A batch checks its folder, which cannot be created, before its problems.
    surely_bad = command != "batch" and not all(map(is_number, text.split(",")))
    return Case(f"number, {command} {option_name}", (*_GOOD[command], *given), {}, surely_bad)


def option(rng: random.Random) -> Case:
    """An unknown, repeated, contradictory or misplaced option, or an odd word."""
    command = rng.choice(list(_GOOD))
    good = list(_GOOD[command])
    surely_bad = rng.random() < 0.25
    odd = rng.choice(
        (
            ("--nowhere", "1"), ("-x",), ("--no-such",), ("--landscape", "3"), ("--json=1",),
            ("--seed", "x"), ("--out",), ("--terrain", "--json"), ("--wind",), ("--origin", "1"),
        )
        if surely_bad
        else (
            ("--",), ("--", "--seed"), ("x" * 5000,), ("\udcff",), ("--seed",),
            ("--start-geo", "46,9,100"), ("--via", "1,2,3", "--via-geo", "4,5,6"),
            ("--as-paper", "--clearance", "5"), ("--origin", "46,9"), ("--cell", "30"),
            ("--planner", ""), ("--planner", "ga-pc", "--beside", ","), ("--uav", ""),
            ("--uav", "../base"), ("--terrain", ""), ("--terrain", "\udcff.tif"),
            ("--terrain", "x" * 5000), ("--terrain", "/dev/zero"), ("--nofly", "/dev/zero"),
            ("--path", "/dev/zero"), ("--nofly", "../base"), ("--path", "../base"), ("--path", ""),
            ("--board", "x"), ("--write", "doc"), ("--write", ""), ("--fallback", ""),
            ("--seed", "1") * 3,
            ("--scheduler", ""), ("--scheduler", "tcp://127.0.0.1:1"), ("--planners", ""),
            ("--planners", "ga-pc,ga-pc"), ("--planners", "ga-pc:generations="),
            ("--planners", "ga-pc:seed=1"), ("--planners", ":::"), ("--gusts", ""), ("--to", ""),
            ("--to", "udpout:x"), ("--to", f"tcp:127.0.0.1:{'9' * 5000}"),
            ("--to", f"tcp:{'x' * 64}.de:9"), ("--aircraft", ""), ("--aircraft", "/dev/zero"),
            ("--engine", "gpu", "--planner", "astar"), ("--save-problem", ""), ("--listen", ""),
            ("--save-problem", "../base"), ("../base/path.csv",), ("../base/summary.json",), ("",),
            ("--out", "x" * 5000), ("--out", "/dev/null"),
            ("--out", f"/proc/self/fd/{'9' * 20}"), ("--out", f"/proc/self/fd/{'9' * 5000}"),
            ("--out", "../base/path.csv"),
            ("--return", "--goal-heading", "400"), ("--jso",),
        )
    )  # fmt: skip
    if rng.random() < 0.2:
        del good[rng.randrange(len(good))]
    at = len(good) if surely_bad or rng.random() < 0.8 else rng.randrange(1, len(good) + 1)
    arguments = (*good[:at], *odd, *good[at:])
    return Case(f"option, {command} {odd[0][:20]}", arguments, {}, surely_bad)


def board(rng: random.Random) -> Case:
    """A URL without a board, or with fields that no board has."""
    fields = "population", "map_size", "max_waypoints", "core", "coarse_factor", "x", "", "sim"
    values = *_LONG, "33", "-1", "0", "nan", "", "x", "1e9"
    query = "&".join(
        f"{rng.choice((*fields, 'idle_clocks', 'baud', 'patience'))}={rng.choice(values)}"
        for _ in range(rng.randint(1, 3))
    )
    url = rng.choice(
        (
            f"model:?{query}", f"model:?{query}", f"sim:?x=1&{query}", f"sim:?=1&{query}",
            "socket://127.0.0.1:1", "socket://", "socket://127.0.0.1:99999", "socket://[",
            f"/dev/ptmx?baud={rng.choice(_LONG)}", f"/dev/null?{query}",
            f"sim:?idle_clocks={'9' * 5000}",
            f"socket://127.0.0.1:{'9' * 5000}", "/dev/null", "/dev/full", "../base",
            "../base/path.csv", "", " ", "x" * 5000, "\udcff",
            "rfc2217://127.0.0.1:1", "http://127.0.0.1", "loop://?x", "hwgrep://nothing", "spy://",
            "spy:///dev/null?x=1", "alt://", "://", "model", "model:x", "model:?",
            "model:?population", "sim",
        )
    )  # fmt: skip
    arguments = rng.choice(
        (
            ("board", "info"),
            ("feasible", "--map", "../base/map.npy", "--path", "../base/cells.csv"),
            ("plan", *_ENDS, *_NOWHERE),
        )
    )
    return Case(f"board, {arguments[0]}", (*arguments, "--board", url))
