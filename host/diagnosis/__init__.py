"""Reasons why a problem has no path: the limit that prevents it, the place, and a remedy."""

from pathgene.host.diagnosis.ladder import diagnose
from pathgene.host.diagnosis.reason import Figure, Reason


__all__ = ["Figure", "Reason", "diagnose"]
