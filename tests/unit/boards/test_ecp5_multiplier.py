# amaranth: UnusedElaboratable=no
"""The ECP5's multiplier equals the simulated product in every cycle."""

import pytest
from amaranth.back import verilog

from pathgene.hdl.primitives.arithmetic import Multiplier
from tests.support.gateware.ecp5_twins import ECP5, twins_of


def primitive():
    """Return a Verilog model of MULT18X18D, after its data sheet, for the options in use."""
    first, second, third = (
        ", ".join(f"{name}{i}" for i in reversed(range(18))) for name in ("A", "B", "C")
    )
    product = ", ".join(f"P{i}" for i in reversed(range(36)))
    names = ["INPUTA_CLK", "INPUTB_CLK", "INPUTC_CLK", "PIPELINE_CLK"]
    names += ["OUTPUT_CLK", "OUTPUT_CE", "OUTPUT_RST"]
    parameters = [f"parameter REG_{name} = 0" for name in names]
    parameters += [
        f"parameter {name} = 0" for name in ("SOURCEB_MODE", "MULT_BYPASS", "RESETMODE", "GSR")
    ]
    return f"""
        module MULT18X18D #({", ".join(parameters)}) (
            input CLK0, CE0, RST0, SIGNEDA, SIGNEDB, SOURCEA, SOURCEB,
            input {first}, {second}, {third}, output {product});
            wire signed [18:0] first = {{SIGNEDA & A17, {first}}};
            wire signed [18:0] second = {{SIGNEDB & B17, {second}}};
            wire [35:0] now = first * second;
            reg [35:0] then;
            wire plain = REG_INPUTA_CLK == "NONE" && REG_INPUTB_CLK == "NONE"
                && REG_PIPELINE_CLK == "NONE" && MULT_BYPASS == "DISABLED" && !SOURCEA && !SOURCEB;
            assign {{{product}}} = !plain ? 36'bx : REG_OUTPUT_CLK == "CLK0" ? then : now;
            always @(posedge CLK0) if (RST0) then <= 0; else if (CE0) then <= now;
        endmodule
        """


BENCH = """
module bench;
    reg clk = 0;
    reg [{first}:0] first = 0;
    reg [{second}:0] second = 0;
    wire [{top}:0] simulated, built;
    simulated one(.clk(clk), .rst(1'b0), .first(first), .second(second), .product(simulated));
    built other(.clk(clk), .rst(1'b0), .first(first), .second(second), .product(built));
    integer cycle, seed = 7, differing = 0, seen = 0;
    initial begin
        for (cycle = 0; cycle < 5000; cycle = cycle + 1) begin
            first = cycle % 3 ? $random(seed) : cycle % 2 ? 0 : {{(1 + {first}){{1'b1}}}};
            second = cycle % 5 ? $random(seed) : {{1'b1, {second}'b0}};
            #1 clk = 1;
            #1 clk = 0;
            #1 if (simulated !== built) differing = differing + 1;
            if (^built !== 1'bx && built != 0) seen = seen + 1;
        end
        $display("%0d differ, %0d seen", differing, seen);
    end
endmodule
"""


@pytest.mark.parametrize(
    ("bits", "shift", "signs"),
    [
        ((13, 18), 17, (True, True)),
        ((16, 16), 0, (True, True)),
        ((18, 18), 5, (True, True)),
        ((18, 18), 0, (False, False)),
        ((18, 18), 0, (True, False)),
        ((17, 18), 1, (False, True)),
    ],
)
def test_equals_the_simulated_product(bits, shift, signs, tmp_path, icarus):
    bench = BENCH.format(first=bits[0] - 1, second=bits[1] - 1, top=sum(bits) - shift - 1)
    simulated, built = twins_of(
        lambda: Multiplier(bits, shift, signs), primitive(), bench, tmp_path
    )
    assert built.count("MULT18X18D") == 1
    assert "always @(posedge" not in built
    assert "MULT18X18D" not in simulated


@pytest.mark.parametrize("bits", [(13, 19), (18, 3)], ids=["wide", "narrow"])
def test_other_factors_use_the_generic_product(bits):
    built = verilog.convert(Multiplier(bits), platform=ECP5, emit_src=False)
    assert built == verilog.convert(Multiplier(bits), emit_src=False)
    assert "MULT18X18D" not in built
