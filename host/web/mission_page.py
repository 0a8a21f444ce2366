"""The page of a checked mission: its flight, and its faults as marks and as a list."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from pathgene.host.mission.foreign.check import MissionCheck
from pathgene.host.mission.foreign.drawn import DrawnFlight, drawn_flight
from pathgene.host.mission.foreign.picture import titles
from pathgene.host.report.handed_over import HandedOver
from pathgene.host.web.page import page_of_scene
from pathgene.host.web.scene import columns_scene, mission_scene, problem_scene


__all__ = ["check_scene", "flight_scene", "page_of_check"]


def page_of_check(check: MissionCheck, name: str) -> str:
    """Return the page of a mission of that name, which flies a leg or more.

    Raises
    ------
    InputError
        If the extra ``desk``, whose three.js the page contains, is not installed.
    """
    return page_of_scene(check_scene(check, name))


def check_scene(check: MissionCheck, name: str) -> dict[str, Any]:
    """Return the scene of a mission, its flight as :func:`flight_scene` returns it."""
    title, subtitle = titles(check, name)
    return {
        **problem_scene(check.judge.problem),
        **flight_scene(check, name),
        "title": title,
        "subtitle": subtitle,
        "verdict": {"feasible": check.feasible, "sentence": ""},
        "figures": [
            # Without the leg or the number of legs, for which a figure has no room.
            {"key": key, "label": key.capitalize(), "value": text, "text": text.split(", ")[0]}
            for key, text in check.pairs
        ],
    }


def flight_scene(check: MissionCheck, name: str) -> dict[str, Any]:
    """Return ``points``, ``paths`` and ``faults`` of a scene; see :mod:`pathgene.host.web.scene`.

    Samples of NaN separate parts that are flown on their own. A mission without a leg has no path.
    """
    flown = drawn_flight(check)
    ends = zip(("start", "goal"), flown.points[[0, -1]].tolist(), strict=True)
    return {
        "points": [
            {"kind": kind, "name": kind, "x": x, "y": y, "z": z, "ground_m": None}
            for kind, (x, y, z) in ends
        ],
        "paths": [_path(flown, name)] if len(flown.samples.s) else [],
        "faults": [
            {
                "sentence": table["sentence"],
                **dict(zip("xyz", mark.place, strict=True)),
                "at_m": mark.at_m,
            }
            for mark, table in zip(flown.marks, check.tables, strict=True)
        ],
    }


def _path(flown: DrawnFlight, name: str) -> dict[str, Any]:
    # The distance flown stays ascending, because views search in it.
    samples = replace(flown.samples, s=np.fmax.accumulate(flown.samples.s))
    none = np.empty((0, 3))
    mission = HandedOver(none, none, none, none, flown.circles, none)
    track = {
        "length_m": float(samples.s[-1]),
        **columns_scene(samples, flown.ground, samples.z - flown.highest, flown.demanded),
        "broken": [
            {"limit": limit, "from_m": first, "to_m": last} for limit, first, last in flown.spans
        ],
    }
    return {
        "name": name,
        "waypoints": flown.points.tolist(),
        "mission": mission_scene(mission) if flown.circles else None,
        "track": track,
    }
