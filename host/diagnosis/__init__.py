"""Reasons why a problem has no path: which limit forbids every one, where, and what would do."""

from pathgene.host.diagnosis.ladder import diagnose
from pathgene.host.diagnosis.reason import Figure, Reason


__all__ = ["Figure", "Reason", "diagnose"]
