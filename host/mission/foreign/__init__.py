"""Missions of any ground station: flown by an aircraft over a terrain, judged and explained."""
