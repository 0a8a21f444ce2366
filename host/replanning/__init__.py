"""Replanning in flight: zones appear, the goal or the wind changes, and the flight continues."""
