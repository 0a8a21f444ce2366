"""Wavefront of the planner: blocks of the map, costs to the goal, routes, and seeds along them."""
