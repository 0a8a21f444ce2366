"""The scorer: computes costs, penalties and chords from the points of paths."""
