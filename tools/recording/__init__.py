"""Parts of :mod:`tools.record`, one module for each area of the program."""
