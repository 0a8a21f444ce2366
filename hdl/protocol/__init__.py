"""The protocol between host and chip: messages, codes and layouts. Pure Python.

Frame
-----
A frame is ``COBS(body | CRC-32) 0x00``. The body has at least 3 bytes: session, sequence, code,
then a payload. The CRC is the CRC-32 of IEEE 802.3 (as in zlib), least significant byte first, with
each byte XORed with :data:`VERSION`, so that ends of different versions reject each other's frames.
Frames of :data:`Command.INFO` are *plain*: their CRC is not XORed and their layout never changes,
so every host can ask any chip for its version.

Order
-----
A host opens the session after the chip's current one, modulo 256 (:data:`Command.OPEN`); this sets
the expected sequence number to 0. Opening the current session changes nothing. Opening any other
session is answered with :data:`Status.NO_SESSION`, so a delayed frame cannot open one. Every
command except ``INFO`` and ``OPEN`` carries the session and the next sequence number, modulo 256.
The chip

- executes the command with the expected number, answers, and expects the next number;
- repeats the answer of the previous command without executing it again (the answer was lost);
- answers :data:`Status.DUPLICATE` to the 126 numbers before these, :data:`Status.OUT_OF_ORDER` to
  all remaining numbers;
- answers :data:`Status.NO_SESSION` to another session, and nothing to a damaged frame.

A refused command (its status is an error) does not count as executed: its number stays the expected
one. A repeated GENERATE may ask for a different :class:`LinkMode` than the first time, and a
repeated check for :data:`CheckFlag.BRIEF`, so a host can settle for a short answer if long answers
are damaged. A command is executed exactly once and in order, even if the line loses, damages,
repeats or reorders frames. A host may have several commands unanswered as long as their bodies with
CRCs fit in :attr:`pathgene.hdl.config.Config.receive_buffer`; an answer confirms every command up
to its own.

The answer has the command's session and sequence, a :class:`Status` as code, and the payload of the
reply; with a status other than ``OK`` there is no payload.

Payloads are bit fields without gaps, each least significant bit first, the first field lowest,
padded with zeros to whole bytes. A waypoint takes ``waypoint_bytes``: x, y, altitude, then a bit
that marks the last waypoint of its path. A cell of the map takes ``altitude_bits``; cells follow
each other without gaps.
"""

from pathgene.hdl.protocol.codec import (
    BODY_HEADER_BYTES,
    CRC_BYTES,
    DELIMITER,
    LINE_BITS,
    VERSION,
    frame_crc,
)
from pathgene.hdl.protocol.codes import (
    COUNTER_BITS,
    CheckFlag,
    ChipState,
    Command,
    Counter,
    LinkMode,
    Status,
    StickyError,
)
from pathgene.hdl.protocol.layout import Layout
from pathgene.hdl.protocol.messages import (
    check_paths_request,
    check_reply,
    check_request,
    config_from_info,
    counters_reply,
    entry_record,
    generate_request,
    hit_record,
    info_reply,
    info_values,
    map_request,
    path_record,
    read_request,
    recipe_reply,
    results_request,
    start_request,
    status_reply,
    survivors_reply,
    write_request,
)
from pathgene.hdl.protocol.paths import (
    PathResult,
    pack_cells,
    pack_paths,
    pack_results,
    unpack_cells,
    unpack_paths,
    unpack_results,
)


__all__ = [
    "BODY_HEADER_BYTES",
    "COUNTER_BITS",
    "CRC_BYTES",
    "DELIMITER",
    "LINE_BITS",
    "VERSION",
    "CheckFlag",
    "ChipState",
    "Command",
    "Counter",
    "Layout",
    "LinkMode",
    "PathResult",
    "Status",
    "StickyError",
    "check_paths_request",
    "check_reply",
    "check_request",
    "config_from_info",
    "counters_reply",
    "entry_record",
    "frame_crc",
    "generate_request",
    "hit_record",
    "info_reply",
    "info_values",
    "map_request",
    "pack_cells",
    "pack_paths",
    "pack_results",
    "path_record",
    "read_request",
    "recipe_reply",
    "results_request",
    "start_request",
    "status_reply",
    "survivors_reply",
    "unpack_cells",
    "unpack_paths",
    "unpack_results",
    "write_request",
]
