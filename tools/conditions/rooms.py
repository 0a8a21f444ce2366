"""Rooms of the host whose coverage is measured."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path


__all__ = ["LEAST_PERCENT", "ROOMS", "ROOT", "Room", "files_of", "module_of"]

ROOT = Path(__file__).resolve().parents[2]
#: Minimum share of a room's branches that tests must run.
LEAST_PERCENT = 95.0


@dataclass(frozen=True)
class Room:
    """Modules that judge safety: a row of the table.

    Parameters
    ----------
    paths : tuple of str
        Files and folders; a file that an earlier room names is not in this one.
    needs_pairs : bool
        True if each condition needs a pair.
    """

    name: str
    paths: tuple[str, ...]
    needs_pairs: bool = False


_VERDICT = (
    "aircraft_limits",
    "broken",
    "crossings",
    "kernels",
    "laid_track",
    "laying",
    "packed_zones",
    "pieces",
    "rule_kernels",
    "strict_rule",
    "terrain_rule",
    "zones",
)

#: The first room is every module that gives the strict verdict on a path.
ROOMS = (
    Room("strict rule", tuple(f"host/evaluation/{name}.py" for name in _VERDICT), needs_pairs=True),
    Room(
        "evaluation, the rest",
        ("host/evaluation", "host/checking.py", "host/flight/ground.py", "host/flight/judge.py"),
    ),
    Room("problem", ("host/problem",)),
    Room("terrain", ("host/terrain",)),
    Room("formats", ("host/formats",)),
    Room("mission", ("host/mission",)),
)


def files_of(room: Room) -> Iterator[str]:
    """Yield the files of a room, as paths from the root."""
    taken = {path for each in ROOMS[: ROOMS.index(room)] for path in each.paths}
    for path in room.paths:
        place = ROOT / path
        for file in sorted(place.rglob("*.py")) if place.is_dir() else (place,):
            if (name := file.relative_to(ROOT).as_posix()) not in taken:
                yield name


def module_of(file: str) -> str:
    """Return the name under which a file of a room is imported."""
    return f"pathgene.{file.removesuffix('.py').removesuffix('/__init__').replace('/', '.')}"
