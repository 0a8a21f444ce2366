"""Comparison of planners over many seeds: parallel runs, stored as they end, with statistics."""
