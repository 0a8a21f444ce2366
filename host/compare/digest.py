"""Digests that identify the runs of one problem and one planner."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from pathgene.host.problem.problem import Problem


__all__ = ["digest_of", "problem_digest"]

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
