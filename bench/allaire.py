"""Table 1 of *allaire-2008*: seconds for 60 generations, on the PC alone and with the FPGA."""

from __future__ import annotations

from dataclasses import dataclass


__all__ = ["CLOCK_HZ", "GENERATIONS", "PHASES", "Phase"]

GENERATIONS = 60
#: Clock of the paper's FPGA. The PC was a Pentium 4 of 2.8 GHz.
CLOCK_HZ = 100e6


@dataclass(frozen=True)
class Phase:
    """A phase of the genetic algorithm that the paper moved to the FPGA.

    Parameters
    ----------
    key : str
        Name of its time in a result of ``ga-pc``, and of its cycles in a result of ``ga-fpga``.
    pc_s, fpga_s : float
        The paper's measurements.
    """

    key: str
    pc_s: float
    fpga_s: float

    @property
    def cycles(self) -> float:
        """Return the cycles of a generation on the paper's FPGA."""
        return self.fpga_s * CLOCK_HZ / GENERATIONS


PHASES = {
    "selection and crossover": Phase("selection_crossover", 94e-3, 8.85e-6),
    "mutation": Phase("mutation", 2e-3, 18e-6),
    "population update": Phase("population_update", 30e-3, 600e-9),
}
