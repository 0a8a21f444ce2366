"""Place of the collision checker of *allaire two-tier*: nothing is built here yet."""
