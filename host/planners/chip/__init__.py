"""``ga-chip``: plans by runs of the planner core."""
