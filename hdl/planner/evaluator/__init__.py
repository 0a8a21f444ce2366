"""Evaluator of paths: score, walk, and key."""
