"""Short flights over small terrains."""

from tests.support.host.short_flights import make_run


__all__ = ["make_run"]
