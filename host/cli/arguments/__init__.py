"""Arguments of each command, a module a command, and the groups that commands share.

These modules import nothing heavy, so that ``--help`` answers at once.
"""
