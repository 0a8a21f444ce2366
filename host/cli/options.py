"""The options that only some planners have."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from pathgene.host.cli.output import note
from pathgene.host.planners import OPTIONS, PLANNERS


__all__ = ["ignored_options", "own_options"]


def own_options(args: argparse.Namespace, *planners: str) -> dict[str, Any]:
    """Return the given options that one of ``planners`` has; note those that none has."""
    given = {name: getattr(args, name) for name in OPTIONS if getattr(args, name) is not None}
    ignored = ignored_options(given, *planners)
    names = " or ".join(dict.fromkeys(planners))
    for name in ignored:
        note(f"--{name.replace('_', '-')} means nothing to {names} and is ignored.")
    return {name: value for name, value in given.items() if name not in ignored}


def ignored_options(values: Mapping[str, Any], *planners: str) -> list[str]:
    """Return the names of the options in ``values`` that none of ``planners`` has, sorted."""
    given = {name for name in OPTIONS if values.get(name) is not None}
    # Making the planner reports an unknown name.
    known = [PLANNERS[name].options if name in PLANNERS else given for name in planners]
    return sorted(given.difference(*known))
