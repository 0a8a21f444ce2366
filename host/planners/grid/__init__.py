"""``astar``: search on a grid, and first populations made from its paths for other planners."""
