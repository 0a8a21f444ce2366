"""Draws the pictures of ``docs/architecture.md`` from the gateware and from the imports."""
