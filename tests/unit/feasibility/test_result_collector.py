# amaranth: UnusedElaboratable=no
"""Sizes of the unit that sums up steps; what it sums up is tested with the walkers."""
