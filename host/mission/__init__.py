"""Missions: legs planned as one path, problem files, batches, and files for other programs."""
