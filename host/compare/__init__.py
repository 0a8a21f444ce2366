"""Planners compared over many seeds: runs in parallel, kept as they end, statistics, a picture."""
