"""``ga-chip``: planning by runs of the planner core."""
