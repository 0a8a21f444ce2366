"""A simulated autopilot: it flies missions as ArduPlane does, and answers MAVLink as it does.

Facts and formulas come from the public documentation and sources of ArduPilot and PX4; no code of
theirs is in here. Nothing of the host is used, so that the judge shares no code with the judged.

- ``airframe``, ``dynamics`` and ``vehicle``: a point mass with bank and pitch, in wind
- ``lateral``, ``npfg`` and ``height``: the laws of guidance of ArduPlane and PX4
- ``items``, ``targets`` and ``sequencer``: the mission, item by item, ten times a second
- ``lists``, ``rules`` and ``fence``: the protocol of missions, fences and rally points
- ``autopilot``: these parts under ``handle(message, now)`` and ``advance(now)``
- ``link`` and ``served``: a link that loses and delays, in virtual time, and UDP
"""
