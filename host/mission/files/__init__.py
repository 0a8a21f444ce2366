"""Missions as files of ground stations, as KML and GeoJSON, and on their way to an autopilot."""
