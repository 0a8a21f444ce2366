"""The parts of :mod:`tools.record`: each module records one side of the program."""
