"""A fault simulator: whole sessions of the product under faults drawn from a seed.

``python -m tools.faults`` (``make faults``) runs sessions on the software model and on the
Verilated chip, with faults of the line, the chip, the processor's clock and the disk, and with
signals at any line of the host's code. Time is virtual, so minutes of silence take milliseconds.

A case (:mod:`tools.faults.case`) is a list of explicit events, drawn from its seed: it replays
exactly, and shrinks by leaving events out. A judge (:mod:`tools.faults.judge`) checks the promises
that every session must keep under any fault: the host gets the same answers as without faults, or
the call fails with a documented error; nothing hangs; files on disk are whole; a later session
works. Planted bugs (:mod:`tools.faults.planted`) show that the judge would notice.
"""
