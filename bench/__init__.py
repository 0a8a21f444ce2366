"""Benchmarks: measurements of every claim of speed and quality."""
