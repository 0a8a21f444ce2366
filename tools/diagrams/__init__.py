"""Drawings of the pictures in ``docs/architecture.md`` from the gateware and from the imports."""
