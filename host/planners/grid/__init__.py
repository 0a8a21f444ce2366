"""``astar``: search on a grid, and the first populations that other planners make of its paths."""
