"""Frequencies and limits of the PLLs."""

import pytest

from pathgene.hdl.boards.pll import Ecp5Pll, Ice40Pll, Series7Pll


@pytest.mark.parametrize(
    ("pll", "reference_mhz", "output_mhz"),
    [
        (Ecp5Pll(feedback_divider=4, output_divider=6), 25, 100),
        (Ecp5Pll(feedback_divider=1, second_divider=26, output_divider=8), 25, 81.25),
        (Ecp5Pll(input_divider=5, feedback_divider=6, output_divider=5), 100, 120),
        # The settings of icepll for 12 to 24 MHz.
        (Ice40Pll(divf=63, divq=5), 12, 24),
        (Ice40Pll(divr=3, divf=63, divq=5, filter_range=1), 48, 24),
        (Series7Pll(clkfbout_mult=10, clkout0_divide=8), 100, 125),
        (Series7Pll(divclk_divide=2, clkfbout_mult=32, clkout0_divide=16), 100, 100),
    ],
)
def test_output(pll, reference_mhz, output_mhz):
    assert pll.output_hz(reference_mhz * 1_000_000) == output_mhz * 1_000_000


@pytest.mark.parametrize(
    ("pll", "reference_mhz", "rule"),
    [
        (Ecp5Pll(feedback_divider=4, output_divider=0), 25, "output_divider must be from 1 to 128"),
        (
            Ecp5Pll(feedback_divider=1, second_divider=0, output_divider=8),
            25,
            "second_divider must be from 1 to 128",
        ),
        (
            Ecp5Pll(feedback_divider=1, second_divider=33, output_divider=8),
            25,
            "oscillator must be from 400 to 800 MHz",
        ),
        (
            Ecp5Pll(feedback_divider=4, output_divider=3),
            25,
            "oscillator must be from 400 to 800 MHz",
        ),
        (
            Ecp5Pll(feedback_divider=4, output_divider=9),
            25,
            "oscillator must be from 400 to 800 MHz",
        ),
        (
            Ecp5Pll(input_divider=5, feedback_divider=8, output_divider=15),
            25,
            "detector must be from 10 to 400 MHz",
        ),
        (
            Ecp5Pll(input_divider=7, feedback_divider=4, output_divider=8),
            100,
            "output must be a whole number of hertz",
        ),
        (Ice40Pll(divf=63, divq=0), 12, "divq must be from 1 to 6"),
        (Ice40Pll(divf=128, divq=5), 12, "divf must be from 0 to 127"),
        (Ice40Pll(divr=16, divf=63, divq=5), 12, "divr must be from 0 to 15"),
        (Ice40Pll(divf=63, divq=5, filter_range=7), 12, "filter_range must be from 1 to 6"),
        (Ice40Pll(divf=40, divq=5), 12, "oscillator must be from 533 to 1066 MHz"),
        (Ice40Pll(divr=1, divf=127, divq=5), 12, "detector must be from 10 to 133 MHz"),
        (Series7Pll(clkfbout_mult=65, clkout0_divide=8), 100, "clkfbout_mult must be from 2 to 64"),
        (
            Series7Pll(clkfbout_mult=7, clkout0_divide=7),
            100,
            "oscillator must be from 800 to 1600 MHz",
        ),
        (
            Series7Pll(divclk_divide=6, clkfbout_mult=50, clkout0_divide=8),
            100,
            "detector must be from 19 to 450 MHz",
        ),
        (Series7Pll(divclk_divide=57, clkfbout_mult=8, clkout0_divide=8), 100, "from 1 to 56"),
        (Series7Pll(clkfbout_mult=8, clkout0_divide=129), 100, "from 1 to 128"),
    ],
)
def test_limits(pll, reference_mhz, rule):
    with pytest.raises(
        ValueError, match=rf"^{type(pll).__name__}\..*{rule}, not {type(pll).__name__}"
    ):
        pll.output_hz(reference_mhz * 1_000_000)
