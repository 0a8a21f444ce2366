"""Short flights over small terrains."""
