"""Wavefront of the planner core: blocks of the map, costs to the goal, routes, and seeds."""
