"""The parallel build of the checker: every segment in the detailed map, several cells per cycle."""
