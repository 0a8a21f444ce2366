"""The protocol between host and chip: messages, codes and layouts. Pure Python.

Frame
-----
A frame is ``COBS(body | CRC-32) 0x00``. The body has at least 3 bytes: session, sequence, code,
then a payload. The CRC is the CRC-32 of IEEE 802.3 (as in zlib), least significant byte first, with
each byte XORed with ``VERSION``, so that ends of different versions reject each other's frames.
Frames of ``Command.INFO`` are *plain*: their CRC is not XORed and their layout never changes,
so every host can ask any chip for its version.

Order
-----
A host opens the session after the chip's current one, modulo 256 (``Command.OPEN``); this sets
the expected sequence number to 0. Opening the current session changes nothing. Opening any other
session is answered with ``Status.NO_SESSION``, so a delayed frame cannot open one. Every
command except ``INFO`` and ``OPEN`` carries the session and the next sequence number, modulo 256.
The chip

- executes the command with the expected number, answers, and expects the next number;
- repeats the answer of the previous command without executing it again (the answer was lost);
- answers ``Status.DUPLICATE`` to the 126 numbers before these, ``Status.OUT_OF_ORDER`` to
  all remaining numbers;
- answers ``Status.NO_SESSION`` to another session, and nothing to a damaged frame.

A refused command (its status is an error) does not count as executed: its number stays the expected
one. A repeated GENERATE may ask for a different ``LinkMode`` than the first time, and a
repeated check for ``CheckFlag.BRIEF``, so a host can settle for a short answer if long answers
are damaged. A command is executed exactly once and in order, even if the line loses, damages,
repeats or reorders frames. A host may have several commands unanswered as long as their bodies with
CRCs fit in :attr:`pathgene.hdl.config.Config.receive_buffer`; an answer confirms every command up
to its own.

The answer has the command's session and sequence, a ``Status`` as code, and the payload of the
reply; with a status other than ``OK`` there is no payload.

Payloads are bit fields without gaps, each least significant bit first, the first field lowest,
padded with zeros to whole bytes. A waypoint takes ``waypoint_bytes``: x, y, altitude, then a bit
that marks the last waypoint of its path. A cell of the map takes ``altitude_bits``; cells follow
each other without gaps.
"""
