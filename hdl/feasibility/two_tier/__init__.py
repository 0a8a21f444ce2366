"""The two-tier build of the checker: one cell per cycle.

It reads the detailed map near the aircraft and the coarse map beyond.
"""
