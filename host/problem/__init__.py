"""Planning problems: start, goal, aircraft, zones, and their map on the chip."""

from host.problem.aircraft import Aircraft
from host.problem.chip_map import ChipMap
from host.problem.problem import Problem
from host.problem.rules import Rules
from host.problem.zones import Circle, Polygon, Zone


__all__ = ["Aircraft", "ChipMap", "Circle", "Polygon", "Problem", "Rules", "Zone"]
