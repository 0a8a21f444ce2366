"""The planner core: one child after another is bred, scored, walked and sorted."""
