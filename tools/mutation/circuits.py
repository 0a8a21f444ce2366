"""Comparison of two circuits after optimization, up to names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tools.netlist import Netlist


__all__ = ["OptimizedNetlist", "equal_circuits"]

#: Removes logic that no output depends on, such as the constant bit of a register that is too wide.
#: Words are split into bits, so that the place of a bit in its word does not count.
_PASSES = "opt -full; wreduce; opt -full; simplemap; opt -full; opt_clean -purge"


class OptimizedNetlist(Netlist):
    """Netlist in which initial values only count for registers, and once each.

    Optimization leaves several names for the same wire, including constants, in an arbitrary order.
    """

    def __init__(self, module: dict[str, Any], *, port_names: bool = True) -> None:
        nets = {}
        seen = set()
        for name, net in module["netnames"].items():
            attributes = dict(net["attributes"])
            init = reversed(attributes.pop("init", ""))
            nets[name] = {"bits": net["bits"], "attributes": attributes}
            for bit, value in zip(net["bits"], init, strict=False):
                if isinstance(bit, int) and value in "01" and bit not in seen:
                    seen.add(bit)
                    nets[f"{name} {bit}"] = {"bits": [bit], "attributes": {"init": value}}
        super().__init__({**module, "netnames": nets}, port_names=port_names)


def equal_circuits(old: Path, new: Path, top: str) -> bool:
    """Return whether two Verilog files are the same circuit after optimization, up to names."""
    first, second = (OptimizedNetlist.read(path, top, passes=_PASSES) for path in (old, new))
    return first.colours == second.colours
