"""Comparison of components built from ECP5 primitives with their generic versions, in Icarus."""

import re
import subprocess
from types import SimpleNamespace

from amaranth.back import verilog

from pathgene.hdl.boards.ecp5 import MAP_SITES
from pathgene.hdl.boards.ecp5_cells import Ecp5Cells


#: The part of an LFE5U-85F's platform that components use.
ECP5 = SimpleNamespace(cells=Ecp5Cells(MAP_SITES))


def twins_of(make, primitive, bench, folder):
    """Assert that both versions of a component have the same outputs in every cycle of a bench.

    Parameters
    ----------
    make : callable
        Returns the component.
    primitive, bench : str
        Verilog modules. ``bench`` instantiates ``simulated`` and ``built`` and prints how many of
        their outputs differ and how many it compared.
    folder : Path

    Returns
    -------
    simulated, built : str
        Verilog of the component.
    """
    simulated = verilog.convert(make(), name="simulated", emit_src=False)
    built = verilog.convert(make(), name="built", platform=ECP5, emit_src=False)
    sources = {"simulated": simulated, "built": built, "primitive": primitive, "bench": bench}
    files = [folder / f"{name}.v" for name in sources]
    for file, text in zip(files, sources.values(), strict=True):
        file.write_text(text)
    program = folder / "bench"
    subprocess.run(["iverilog", "-g2012", "-s", "bench", "-o", program, *files], check=True)
    output = subprocess.run(["vvp", program], check=True, capture_output=True, text=True).stdout
    differing, seen = map(int, re.search(r"(\d+) differ, (\d+) seen", output).groups())
    assert differing == 0
    assert seen > 2000
    return simulated, built
