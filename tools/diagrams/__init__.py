"""Generator of the pictures in ``docs/architecture.md`` from the gateware and the imports."""
