"""Reasons why a problem has no path: which limit forbids every one, where, and what would do."""

from host.diagnosis.ladder import diagnose
from host.diagnosis.reason import Figure, Reason


__all__ = ["Figure", "Reason", "diagnose"]
