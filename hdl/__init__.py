"""Gateware of pathgene, and the two definitions everyone shares: configuration and protocol."""
