"""Walker of the planner: collisions and margins of paths, with a memo of segments."""
