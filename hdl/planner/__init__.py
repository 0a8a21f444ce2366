"""The whole planner on the chip: one child after another is bred, scored, walked and sorted."""
