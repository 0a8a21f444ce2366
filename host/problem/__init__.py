"""Planning problems: start, goal, aircraft, zones, and their map on the chip."""

from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.chip_map import ChipMap
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon, Zone


__all__ = ["Aircraft", "ChipMap", "Circle", "Polygon", "Problem", "Rules", "Zone"]
