"""Plans for the tests of pages: every kind of problem that a page must show, planned once."""

from functools import cache

import numpy as np

import pathgene
from pathgene.host.evaluation import Evaluator
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain
from pathgene.host.web.page import page_of


CELL_M = 40.0


def hills(rows=61, columns=76, *, void=False, crs=None):
    """Terrain of gentle hills, with or without a lake of voids."""
    y, x = np.mgrid[0:rows, 0:columns]
    heights = 300 + 45 * np.sin(x / 9) * np.cos(y / 7) + 0.5 * x
    if void:
        heights[25:36, 30:45] = np.nan
    origin = None if crs is None else (5e5, 5e6)
    return Terrain("hills", heights, CELL_M, CELL_M, crs, origin)


ZONES = (
    Zone.circle(1500, 1150, 220, name="mast <A&B>"),
    Zone.polygon(
        [(1900, 1500), (2500, 1500), (2500, 2100), (1900, 2100)],
        [[(2100, 1700), (2300, 1700), (2300, 1900), (2100, 1900)]],
        name="range",
        lower_m=500,
        upper_m=700,
    ),
)
VIA = [(1000, 600, 100), (2500, 600, 100)]
ENDS = {"start": (200, 200, 90), "goal": (2800, 2200, 90), "agl": True}


def problem(**options):
    terrain = options.pop("terrain", None) or hills()
    return Problem(terrain, **{"zones": ZONES, **ENDS, **options})


def shut_in():
    """A problem without a path: a ring of zones around the goal."""
    ring = [(2400, 1900), (2900, 1900), (2900, 2350), (2400, 2350)]
    hole = [(2700, 2100), (2860, 2100), (2860, 2300), (2700, 2300)]
    return problem(zones=[Zone.polygon(ring, [hole], name="ring")])


KINDS = {
    "plain": problem,
    # There is room to turn back beyond the goal.
    "mission": lambda: MissionProblem(
        problem(terrain=hills(rows=71)), via=VIA, return_to_start=True, agl=True
    ),
    "not feasible": shut_in,
    "voids": lambda: problem(terrain=hills(void=True)),
    "on Earth": lambda: problem(terrain=hills(crs="EPSG:32632")),
    "as paper": lambda: problem(as_paper=True),
    "ceilings": lambda: problem(rules=pathgene.Rules(ceiling_m=600, ceiling_agl_m=200)),
}


@cache
def planned(kind):
    """The plan of one of KINDS."""
    return pathgene.plan(KINDS[kind](), planner="astar", generations=2, fallback="none")


@cache
def with_mission():
    """A plan on a map with a place on Earth and with room for a circle at the goal."""
    roomy = problem(terrain=hills(rows=101, columns=106, crs="EPSG:32632"))
    return pathgene.plan(roomy, planner="astar", generations=2, fallback="none")


@cache
def page_text(kind):
    """The page of one of KINDS."""
    plan = planned(kind)
    return page_of(plan.evaluator, plan.path, plan.summary)


def evaluated(terrain):
    """Evaluator and straight path of a problem on some terrain, from corner to corner."""
    margin = 0.1
    x, y = terrain.width_m, terrain.height_m
    straight = Problem(
        terrain,
        (margin * x, margin * y, terrain.highest + 100),
        ((1 - margin) * x, (1 - margin) * y, terrain.highest + 100),
    )
    return Evaluator(straight), np.array([straight.start, straight.goal])
