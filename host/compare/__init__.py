"""Planners compared over many seeds: runs in parallel, kept as they end, statistics, a picture."""

__all__ = ["LOCAL"]

#: The address of a scheduler that asks for a cluster of our own.
LOCAL = "local"
