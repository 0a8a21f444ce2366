"""Benchmarks, which measure every claim of speed and quality."""
