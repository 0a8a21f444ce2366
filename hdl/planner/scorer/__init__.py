"""The scorer: from the points of paths to their costs, penalties and chords."""
