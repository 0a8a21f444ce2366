"""Gateware of pathgene, and the two definitions shared by all: configuration and protocol."""
