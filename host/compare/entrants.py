"""Entrants of a comparison: planners, each with its options."""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pathgene.host.device.boards import known_config
from pathgene.host.errors import InputError
from pathgene.host.options.option import Option
from pathgene.host.options.table import OWN, SEARCH
from pathgene.host.planners import PLANNERS, make
from pathgene.host.planners.base import Options, Planner
from pathgene.host.problem.problem import Problem
from pathgene.host.report.summary import version
from pathgene.host.suggestion import did_you_mean


__all__ = [
    "Entrant",
    "digest_of",
    "parse_entrants",
    "planner_names",
    "problem_digest",
    "split_label",
]


# A value may be a URL; its colons are never followed by a name and an equals sign.
_NEXT_OPTION = re.compile(r":(?=[A-Za-z][\w-]*=)")


@dataclass(frozen=True)
class Entrant:
    """A planner with all its options except the seed.

    Parameters
    ----------
    label : str
        Its name as the user gave it, also used in reports.
    own : mapping
        The planner's own options that are not left at their defaults.
    options : Options
        Options of every planner; the seed is ignored.
    """

    label: str
    planner: str
    own: Mapping[str, Any]
    options: Options

    def make(self) -> Planner:
        """Return the planner.

        Raises
        ------
        InputError
            If it rejects its options.
        """
        return make(self.planner, **self.own)

    def describe(self) -> dict[str, Any]:
        """Return the planner and its options without the seed, as plain JSON values."""
        options = dataclasses.asdict(self.options)
        del options["seed"]
        table = {"planner": self.planner, "options": {**options, **self.own}}
        plain: dict[str, Any] = json.loads(json.dumps(table, default=str))
        return plain

    @property
    def has_hardware(self) -> bool:
        """True if it needs a board that serves one run at a time."""
        board = self.own.get("board")
        return board is not None and known_config(board) is None

    @property
    def key(self) -> str:
        """Digest of everything that its runs depend on, except for the problem and the seed."""
        return digest_of({**self.describe(), "pathgene": version()})


def split_label(label: str) -> list[str]:
    """Return the name of the planner in ``label``, then each ``KEY=VALUE``."""
    return _NEXT_OPTION.split(label.strip())


def planner_names(text: str) -> list[str]:
    """Return the names of the planners in the text of ``--planners``."""
    return [split_label(label)[0] for label in text.split(",")]


def parse_entrants(
    text: str, search: Mapping[str, Any], own: Mapping[str, Any]
) -> tuple[Entrant, ...]:
    """Return the entrants that ``--planners`` names.

    Parameters
    ----------
    text : str
        ``NAME[:KEY=VALUE]...``, separated by commas. Keys are the names in
        :data:`pathgene.host.options.table.SEARCH` and the planner's own options, with ``_`` or
        ``-``.
    search : mapping
        Values of the options in ``SEARCH`` for all entrants; None if not given.
    own : mapping
        Planners' own options, for every planner that has them.

    Raises
    ------
    InputError
        If there is no such planner or option, a value is bad, an option is given twice to one
        entrant, or two entrants are the same.
    """
    entrants: list[Entrant] = []
    for label in text.split(","):
        entrant = _parse(label.strip(), search, own)
        for other in entrants:
            if other.describe() == entrant.describe():
                raise InputError(
                    f"{other.label} and {entrant.label} are the same planner with "
                    "the same options; leave one out, or change an option."
                )
        entrants.append(entrant)
    return tuple(entrants)


def _parse(label: str, search: Mapping[str, Any], own: Mapping[str, Any]) -> Entrant:
    name, *settings = split_label(label)
    if name not in PLANNERS:
        raise InputError(
            f"There is no planner {name!r}{did_you_mean(name, PLANNERS)}; the planners are "
            f"{', '.join(PLANNERS)}."
        )
    entry = PLANNERS[name]
    given = {"generations": entry.generations}
    given |= {key: value for key, value in search.items() if value is not None}
    chosen = {key: value for key, value in own.items() if key in entry.options}
    listed = set()
    for setting in settings:
        key, _, value = setting.partition("=")
        key = key.replace("-", "_")
        if key in listed:
            raise InputError(f"{label}: {key} is given twice; leave one out.")
        listed.add(key)
        if key in SEARCH:
            given[key] = _value(label, SEARCH[key], value)
        elif key in entry.options:
            chosen[key] = _value(label, OWN[key], value)
        else:
            raise InputError(
                f"{label}: {name} has no option {key!r}; it has "
                f"{', '.join((*SEARCH, *entry.options))}."
            )
    try:
        options = Options(**{SEARCH[key].field: value for key, value in given.items()})
        entrant = Entrant(label, name, chosen, options)
        entrant.make()  # Reject bad options before anything runs.
    except InputError as error:
        raise InputError(f"{label}: {error}") from None
    return entrant


def _value(label: str, option: Option, text: str) -> Any:
    try:
        value = option.kind.parse(text)
        if option.choices and value not in option.choices:
            raise ValueError
    except (ValueError, TypeError, argparse.ArgumentTypeError):
        raise InputError(
            f"{label}: {option.name} must be {option.kind.name}, not {text!r}."
        ) from None
    return value


_DIGITS = 20


def digest_of(value: Any, data: bytes = b"") -> str:
    """Return 20 hexadecimal digits that depend on a plain JSON value and on ``data``."""
    state = hashlib.sha256(json.dumps(value, sort_keys=True).encode())
    state.update(b"\0")
    state.update(data)
    return state.hexdigest()[:_DIGITS]


def problem_digest(problem: Problem) -> str:
    """Return a digest of all inputs of the evaluation; the terrain's name is not one of them."""
    terrain = problem.terrain
    described = {
        "shape": terrain.shape,
        "dx_m": terrain.dx_m,
        "dy_m": terrain.dy_m,
        "start": problem.start,
        "goal": problem.goal,
        "uav": problem.aircraft.to_dict(),
        "nofly": [zone.to_dict() for zone in problem.zones],
        "wind": problem.wind,
        "ds_m": problem.ds_m,
    }
    if problem.rules is not None:
        described |= {
            "rules": problem.rules.to_dict(),
            "headings": [problem.start_heading_deg, problem.goal_heading_deg],
        }
    return digest_of(described, terrain.elevation.tobytes())
