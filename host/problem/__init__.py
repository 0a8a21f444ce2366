"""Planning problems: start, goal, aircraft, zones, and their map on the chip."""
