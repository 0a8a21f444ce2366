"""Walker of the planner core: collisions and margins of paths, with a memo of segments."""
