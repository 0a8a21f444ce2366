"""``pathgene diagnose``."""

from __future__ import annotations

import argparse
from typing import Any

from host.cli.output import print_json, print_pairs
from host.cli.problem import complete_options, make_mission
from host.connection import connect
from host.errors import JobError
from host.evaluation import Evaluator
from host.report.summary import version


__all__ = ["run"]


def run(args: argparse.Namespace) -> int:
    """Look for a path and print that there is one, or the reason of the first leg without one."""
    complete_options(args)
    mission = make_mission(args)
    report: dict[str, Any] = {
        "pathgene": version(),
        "connected": True,
        "leg": None,
        "reason": None,
    }
    sentence = ""
    for number in range(mission.legs):
        problem = mission.problem if mission.legs == 1 else mission.leg(number)
        reason = connect(Evaluator(problem)).reason
        if reason is None:
            continue
        sentence = reason.sentence
        report |= {"connected": False, "reason": reason.to_dict()}
        if mission.legs > 1:
            report["leg"] = number + 1
            name = mission.name_of(number)
            sentence = f"{name[:1].upper()}{name[1:]}: {sentence}"
        break
    if args.json:
        print_json(report)
    else:
        print_pairs(_pairs(report))
    if sentence:
        raise JobError(sentence)
    return 0


def _pairs(report: dict[str, Any]) -> list[tuple[str, str]]:
    reason = report["reason"]
    if reason is None:
        return [("connected", "yes, astar finds a feasible path")]
    pairs = [
        ("connected", "no" if reason["proven"] else "not as far as the search sees"),
        ("reason", reason["code"]),
    ]
    if reason["zones"]:
        pairs.append(("zones", ", ".join(reason["zones"])))
    if reason["place"] is not None:
        pairs.append(("place", "{:.1f}, {:.1f} m".format(*reason["place"])))
    if reason["place_geo"] is not None:
        pairs.append(("latitude, longitude", "{:.6f}, {:.6f}".format(*reason["place_geo"])))
    figure = reason["figure"]
    if figure is not None:
        unit = figure["unit"]
        pairs.append((figure["limit"], f"{figure['allowed']:.6g} {unit}"))
        if figure["would_do"] is not None:
            pairs.append(("would do", f"{figure['would_do']:.6g} {unit}"))
    return pairs
