"""Generator of ``docs/protocol.md`` and ``docs/protocol_frames.json`` from ``hdl/protocol``."""
