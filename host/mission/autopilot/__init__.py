"""Paths for an autopilot: its flight plan with fences, and the upload."""
