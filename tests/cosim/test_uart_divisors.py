"""The UART bench at other divisors: the smallest, and 115,200 baud at 100 MHz."""

import pytest

from pathgene.hdl.link.uart import Uart
from pathgene.hdl.verilog import convert
from pathgene.sim.exported import cached_verilog
from tools.runner import BENCHES, run


pytestmark = pytest.mark.cosim


@pytest.mark.ci
@pytest.mark.parametrize(
    ("simulator", "clocks_per_bit"),
    [
        ("icarus", 4),
        ("verilator", 4),
        ("verilator", 868),
        pytest.param("icarus", 868, marks=pytest.mark.long),
    ],
    indirect=["simulator"],
)
def test_uart(clocks_per_bit, simulator):
    text = cached_verilog(
        lambda: convert(Uart(clocks_per_bit), "uart"),
        "uart",
        repr(clocks_per_bit),
    )
    result = run(
        simulator,
        text,
        "uart",
        BENCHES / "cosim_uart.py",
        env={"CLOCKS_PER_BIT": str(clocks_per_bit)},
        label=f"uart-{clocks_per_bit}-{simulator}",
    )
    assert result.tests == 6
