"""Benchmarks: every speed and quality claim of the README, measured now."""
