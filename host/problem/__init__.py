"""Planning problems: start, goal, aircraft, zones, and the map that the chip gets of them."""
