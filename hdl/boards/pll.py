"""Phase-locked loops of the families: dividers and primitives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields

from amaranth.hdl import Const, Instance, IOPort, Module, Signal
from amaranth.lib import io


__all__ = ["Ecp5Pll", "Ice40Pll", "Pll", "Series7Pll"]


class Pll(ABC):
    """Dividers of a PLL, checked against the family's data sheet when they are used."""

    @abstractmethod
    def output_hz(self, reference_hz: int) -> int:
        """Return the output frequency for an input of ``reference_hz``.

        Raises
        ------
        ValueError
            If the frequency is not a whole number of hertz, or a limit of the family is broken.
        """

    @abstractmethod
    def connect(self, m: Module, port: io.PortLike, clock: Signal, locked: Signal) -> None:
        """Add the primitive to ``m`` and drive both signals; ``port`` is the oscillator's pin."""

    def _check(self, name: str, rule: str, holds: bool) -> None:
        if not holds:
            raise ValueError(f"{type(self).__name__}.{name} must be {rule}, not {self!r}")

    def _check_range(self, name: str, value: float, low: float, high: float, unit: str) -> None:
        self._check(name, f"from {low} to {high} {unit}".rstrip(), low <= value <= high)

    def _whole(self, numerator: int, denominator: int) -> int:
        self._check("output", "a whole number of hertz", numerator % denominator == 0)
        return numerator // denominator


@dataclass(frozen=True, kw_only=True)
class Ecp5Pll(Pll):
    """EHXPLLL of the ECP5, with feedback from its output or from a second output.

    The oscillator runs ``output_divider`` times as fast as the output; with ``second_divider``,
    that many times as fast as the feedback, and the output need not be a multiple of the detector's
    frequency.

    Source: Lattice FPGA-TN-02200 and the ECP5 data sheet: phase detector 10 to 400 MHz, oscillator
    400 to 800 MHz, dividers 1 to 128.
    """

    input_divider: int = 1
    feedback_divider: int
    output_divider: int
    second_divider: int | None = None

    def output_hz(self, reference_hz: int) -> int:
        for each in fields(self):
            if (value := getattr(self, each.name)) is not None:
                self._check_range(each.name, value, 1, 128, "")
        self._check_range("detector", reference_hz / self.input_divider / 1e6, 10, 400, "MHz")
        fed_back = reference_hz * self.feedback_divider
        second = self.second_divider or self.output_divider
        oscillator = fed_back * second / self.input_divider
        self._check_range("oscillator", oscillator / 1e6, 400, 800, "MHz")
        return self._whole(fed_back * second, self.input_divider * self.output_divider)

    def connect(self, m, port, clock, locked):
        m.submodules.reference = reference = io.Buffer("i", port)
        second = {}
        fed_back = clock
        if self.second_divider is not None:
            fed_back = Signal()
            second = {
                "p_CLKOS_ENABLE": "ENABLED",
                "p_CLKOS_DIV": self.second_divider,
                "p_CLKOS_CPHASE": self.second_divider - 1,
                "p_CLKOS_FPHASE": 0,
                "o_CLKOS": fed_back,
            }
        m.submodules.pll = Instance(
            "EHXPLLL",
            # Loop filter, set as by the vendor's tool for this range.
            a_ICP_CURRENT="12",
            a_LPF_RESISTOR="8",
            p_FEEDBK_PATH="CLKOS" if second else "CLKOP",
            p_CLKI_DIV=self.input_divider,
            p_CLKFB_DIV=self.feedback_divider,
            p_CLKOP_ENABLE="ENABLED",
            p_CLKOP_DIV=self.output_divider,
            p_CLKOP_CPHASE=self.output_divider - 1,
            p_CLKOP_FPHASE=0,
            i_CLKI=reference.i,
            i_CLKFB=fed_back,
            i_RST=Const(0),
            i_STDBY=Const(0),
            i_ENCLKOP=Const(0),
            i_PHASESEL0=Const(0),
            i_PHASESEL1=Const(0),
            i_PHASEDIR=Const(1),
            i_PHASESTEP=Const(1),
            i_PHASELOADREG=Const(1),
            i_PLLWAKESYNC=Const(0),
            o_CLKOP=clock,
            o_LOCK=locked,
            **second,
        )


@dataclass(frozen=True, kw_only=True)
class Ice40Pll(Pll):
    """SB_PLL40_PAD of the iCE40, simple feedback.

    Source: Lattice FPGA-TN-02052: phase detector 10 to 133 MHz, oscillator 533 to 1066 MHz; the
    registers hold the dividers minus one, and the logarithm of the last one.
    """

    divr: int = 0
    divf: int
    divq: int
    filter_range: int = 1

    def output_hz(self, reference_hz: int) -> int:
        self._check_range("divr", self.divr, 0, 15, "")
        self._check_range("divf", self.divf, 0, 127, "")
        self._check_range("divq", self.divq, 1, 6, "")
        self._check_range("filter_range", self.filter_range, 1, 6, "")
        detector = reference_hz / (self.divr + 1)
        self._check_range("detector", detector / 1e6, 10, 133, "MHz")
        self._check_range("oscillator", detector * (self.divf + 1) / 1e6, 533, 1066, "MHz")
        return self._whole(reference_hz * (self.divf + 1), (self.divr + 1) << self.divq)

    def connect(self, m, port, clock, locked):
        # The oscillator is on the PLL's own pin, so the primitive takes the pad without a buffer.
        pad: IOPort = port.io
        m.submodules.pll = Instance(
            "SB_PLL40_PAD",
            p_FEEDBACK_PATH="SIMPLE",
            p_DIVR=Const(self.divr, 4),
            p_DIVF=Const(self.divf, 7),
            p_DIVQ=Const(self.divq, 3),
            p_FILTER_RANGE=Const(self.filter_range, 3),
            i_PACKAGEPIN=pad,
            i_RESETB=Const(1),
            i_BYPASS=Const(0),
            o_PLLOUTGLOBAL=clock,
            o_LOCK=locked,
        )


@dataclass(frozen=True, kw_only=True)
class Series7Pll(Pll):
    """PLLE2_BASE of the Xilinx series 7.

    Source: Xilinx DS181, slowest speed grade: phase detector 19 to 450 MHz, oscillator 800 to
    1600 MHz; UG472: the dividers.
    """

    divclk_divide: int = 1
    clkfbout_mult: int
    clkout0_divide: int

    def output_hz(self, reference_hz: int) -> int:
        self._check_range("divclk_divide", self.divclk_divide, 1, 56, "")
        self._check_range("clkfbout_mult", self.clkfbout_mult, 2, 64, "")
        self._check_range("clkout0_divide", self.clkout0_divide, 1, 128, "")
        detector = reference_hz / self.divclk_divide
        self._check_range("detector", detector / 1e6, 19, 450, "MHz")
        self._check_range("oscillator", detector * self.clkfbout_mult / 1e6, 800, 1600, "MHz")
        return self._whole(
            reference_hz * self.clkfbout_mult, self.divclk_divide * self.clkout0_divide
        )

    def connect(self, m, port, clock, locked):
        feedback = Signal()
        unbuffered = Signal()
        m.submodules.reference = reference = io.Buffer("i", port)
        m.submodules.pll = Instance(
            "PLLE2_BASE",
            p_DIVCLK_DIVIDE=self.divclk_divide,
            p_CLKFBOUT_MULT=self.clkfbout_mult,
            p_CLKOUT0_DIVIDE=self.clkout0_divide,
            i_CLKIN1=reference.i,
            i_CLKFBIN=feedback,
            i_RST=Const(0),
            i_PWRDWN=Const(0),
            o_CLKFBOUT=feedback,
            o_CLKOUT0=unbuffered,
            o_LOCKED=locked,
        )
        m.submodules.buffer = Instance("BUFG", i_I=unbuffered, o_O=clock)
