"""The whole planner on the chip, as a bit-exact integer model."""
