"""Verilog of every top and unit: the text that simulations, boards and synthesis all use.

``python -m hdl.verilog FOLDER`` writes those of :data:`SHIPPED`.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from hdl.config import Config
from hdl.zero_init import strip_zero_init


__all__ = ["SHIPPED", "TOPS", "export", "write_shipped"]

#: Module and class of every component that can be exported by name; each takes a Config.
TOPS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "planner": ("hdl.top", "Planner"),
        "ga_core": ("hdl.ga_core.core", "Core"),
        "uart": ("hdl.link.uart", "Uart"),
        "frame_receiver": ("hdl.link.frame", "FrameReceiver"),
        "frame_transmitter": ("hdl.link.frame", "FrameTransmitter"),
        "random_source": ("hdl.ga_core.random_source", "RandomSource"),
        "selection": ("hdl.ga_core.selection", "Selection"),
        "population": ("hdl.ga_core.population", "Population"),
        "crossover": ("hdl.ga_core.crossover", "Crossover"),
        "mutation": ("hdl.ga_core.mutation", "Mutation"),
        "control": ("hdl.control", "Control"),
        "receiving": ("hdl.command.receiver", "CommandReceiver"),
        "transmitting": ("hdl.command.transmitter", "ReplyTransmitter"),
        "path_checker": ("hdl.feasibility.checker", "Checker"),
        "feasibility": ("hdl.feasibility.feasibility", "Feasibility"),
    }
)

#: Tops that ``make verilog`` writes.
SHIPPED = ("ga_core", "feasibility", "planner")


def export(name: str, config: Config) -> str:
    """Return the Verilog of ``name``: one self-contained text, the same for the same ``config``.

    Ports are the members' names joined by ``__``, with ``clk`` and a synchronous ``rst``.

    Raises
    ------
    ValueError
        If there is no such top.
    """
    if name not in TOPS:
        raise ValueError(f"Top must be one of {', '.join(TOPS)}, not {name!r}")
    from amaranth.back import verilog

    module, component = TOPS[name]
    top = getattr(importlib.import_module(module), component)(config)
    return strip_zero_init(verilog.convert(top, name=name, emit_src=False))


def write_shipped(folder: Path, config: Config) -> list[Path]:
    """Write every top of :data:`SHIPPED` to ``folder`` as ``NAME.v`` and return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name in SHIPPED:
        file = folder / f"{name}.v"
        file.write_text(export(name, config), encoding="utf-8")
        files.append(file)
    return files


def main(arguments: Sequence[str] | None = None) -> int:
    """Write what the command line says; returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m hdl.verilog", description=__doc__)
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
