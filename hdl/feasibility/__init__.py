"""The collision checker of *allaire two-tier*: see ``docs/checker.md``."""
