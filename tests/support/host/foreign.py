"""Checks of missions in files, and their remedies applied to the files."""

import copy
import json

import numpy as np

from pathgene.host.formats.registry import read_mission
from pathgene.host.mission.foreign.check import check_mission
from pathgene.host.mission.foreign.judge import FlightProblem
from pathgene.host.problem.zones import read_zones
from pathgene.host.terrain import Terrain
from tests.support.host.planted_missions import CELL_M, CRS, NODES, ORIGIN, degrees, plant


#: A plain at 300 m.
PLAIN = np.full((NODES, NODES), 300.0)
NOWHERE = (0.0, 0.0, 0.0)


def land(heights):
    """Return the terrain of a planted mission."""
    return Terrain("made", heights, CELL_M, CELL_M, CRS, ORIGIN)


def write_planted(folder, kind, *, faulty, seed=1):
    """Write a planted mission and its terrain, and return their files, m.plan and land.npz."""
    planted = plant(kind, seed, faulty=faulty)
    plan, ground = folder / "m.plan", folder / "land.npz"
    with ground.open("wb") as file:
        land(planted.heights).save_npz(file, np.zeros(planted.heights.shape, dtype=bool))
    plan.write_text(planted.plan)
    return plan, ground


def checked(terrain, file, text, *, return_m=None, zones=(), **options):
    """Return the check of a mission, written to a file first."""
    file.write_text(text)
    mission = read_mission(file)
    own = read_zones(file, terrain).zones if mission.has_fences else ()
    problem = FlightProblem(terrain, NOWHERE, NOWHERE, zones=(*zones, *own), **options)
    return check_mission(mission, problem, return_m)


def items_of(document):
    """Return the simple items of a plan and of its surveys by their numbers."""
    found = {}
    for item in document["mission"]["items"]:
        inner = item.get("TransectStyleComplexItem", {"Items": [item]})["Items"]
        found |= {each["doJumpId"]: each for each in inner}
    return found


def applied(document, change, return_m):
    """Return a plan after a change that a report proposes, and the height of the return."""
    after = copy.deepcopy(document)
    items = items_of(after)
    for number, part in enumerate(change["of"]):
        if part == "return":
            return_m += change["raise_m"]
            continue
        params = items[int(part.split()[1])]["params"]
        if "raise_m" in change:
            params[6] += change["raise_m"]
        elif "places" in change:
            params[4:6] = change["places"][number]
        else:
            assert change["leave_out"]
            after["mission"]["items"].remove(items[int(part.split()[1])])
    return json.dumps(after), return_m


def item(command, place=None, alt=0.0, frame=0, params=(0, 0, 0, 0)):
    """Return a simple item; its place is in metres of the land."""
    lat, lon = (0, 0) if place is None else degrees(*place)
    params = [*params, lat, lon, alt]
    return {"type": "SimpleItem", "command": command, "frame": frame, "params": params}


def plan_of(items, home=None, rally=None, firmware=None):
    """Return a plan; home and rally points are in metres of the land."""
    place = None if home is None else [*degrees(*home[:2]), home[2]]
    mission = {"version": 2, "items": items, "plannedHomePosition": place}
    points = [[*degrees(*point[:2]), point[2]] for point in rally or ()]
    return json.dumps(
        {
            "fileType": "Plan",
            "version": 1,
            "mission": mission | {"firmwareType": firmware or 3},
            "rallyPoints": {"points": points},
        }
    )
