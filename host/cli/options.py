"""The options that only some planners have."""

from __future__ import annotations

import argparse
from typing import Any

from host.cli.output import note
from host.planners import OPTIONS, PLANNERS


__all__ = ["own_options"]


def own_options(args: argparse.Namespace, *planners: str) -> dict[str, Any]:
    """Return the given options that one of ``planners`` has; note those that none has."""
    given = {name: getattr(args, name) for name in OPTIONS if getattr(args, name) is not None}
    # Making the planner reports an unknown name.
    known = {
        name
        for planner in planners
        for name in (PLANNERS[planner].options if planner in PLANNERS else given)
    }
    names = " or ".join(dict.fromkeys(planners))
    for name in sorted(set(given) - known):
        note(f"--{name.replace('_', '-')} means nothing to {names} and is ignored.")
    return {name: value for name, value in given.items() if name in known}
