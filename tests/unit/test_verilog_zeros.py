"""Verilog without the zeros of memories that are written before they are read."""

import difflib

from amaranth.back import verilog
from amaranth.hdl import Module
from amaranth.lib import memory

from pathgene.hdl.verilog import strip_zero_init


def two_memories(marked, *, sources=False):
    """Return the Verilog of a memory of zeros and of a memory with other contents."""
    m = Module()
    ports = []
    for name, init in (("zeros", []), ("squares", [i * i for i in range(8)])):
        rows = memory.Memory(shape=8, depth=8, init=init, attrs=marked)
        m.submodules[name] = rows
        read = rows.read_port()
        write = rows.write_port()
        ports += [read.addr, read.data, read.en, write.addr, write.data, write.en]
    return verilog.convert(m, ports=ports, name="top", emit_src=sources)


def test_removes_zeros_of_marked_memories():
    before = two_memories({"no_rw_check": 1})
    after = strip_zero_init(before)
    assert before.count("initial begin") == 2
    assert after.count("initial begin") == 1
    assert "squares[3] = 8'h09;" in after
    assert "zeros[3]" not in after
    assert after.count("no_rw_check") == 2
    gone = [
        line for line in difflib.ndiff(before.splitlines(), after.splitlines()) if line[0] in "+-"
    ]
    assert [line.split() for line in gone] == [
        ["-", "initial", "begin"],
        *(["-", f"zeros[{row}]", "=", "8'h00;"] for row in range(8)),
        ["-", "end"],
    ]


def test_source_locations_do_not_matter():
    after = strip_zero_init(two_memories({"no_rw_check": 1}, sources=True))
    assert "zeros[3]" not in after
    assert "squares[3] = 8'h09;" in after


def test_keeps_other_contents():
    text = two_memories({})
    assert strip_zero_init(text) == text
