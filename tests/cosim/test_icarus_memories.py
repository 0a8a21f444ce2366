"""Exported Verilog on Icarus, where a memory without initial contents would be unknown."""

import re
import subprocess

import numpy as np
import pytest

from pathgene.hdl.planner.wavefront.wavefront import Wavefront
from pathgene.hdl.protocol.planner import BLOCKS, COARSE_BLOCKS
from pathgene.hdl.verilog import convert
from pathgene.sim.cache import BuildCache
from pathgene.sim.icarus import build_icarus, with_zeros
from pathgene.sim.model.planner.course import problem_vector, sizes_vector
from pathgene.sim.model.planner.run_cycles import spreading
from pathgene.sim.model.planner.wavefront import PRICES, measure_distances, measure_prices, spread
from tests.support.planner.cases import SMALL, record
from tests.support.planner.flight import problem_payload


pytestmark = pytest.mark.cosim

GOAL = 22 * BLOCKS + 26
#: All blocks are free; the altitude of block n = 64 y + x is the lowest eight bits of 37 n.
BENCH = """
module bench;
    reg clk = 1'b0, rst = 1'b1, launch = 1'b0;
    reg [11:0] number;
    reg [18:0] block;
    wire [11:0] map_block;
    wire [8:0] passes;
    wire busy;
    integer cycle = 0, taken = 0;
    wavefront dut (
        .clk(clk), .rst(rst), .launch(launch), .busy(busy), .passes(passes), .problem(PROBLEM),
        .map_block(map_block), .block(block), .limit(4'd0), .fine(1'b0), .goal(12'dGOAL),
        .read_block(12'd0), .before(8'd0), .after(8'd0)
    );
    always @(posedge clk) begin
        number <= map_block;
        block <= {10'd0, number * 8'd37 & 8'd255, 1'b1};
    end
    always begin
        #1 clk = 1'b1;
        #1 clk = 1'b0;
        cycle = cycle + 1;
        rst = cycle < 4;
        launch = cycle == 10;
        taken = taken + busy;
        if (cycle > 12 && !busy || cycle == 200000) begin
            $display("%0d %0d", passes, taken);
            $finish;
        end
    end
endmodule
"""


def test_a_wavefront_ends(icarus, tmp_path):
    """An unknown cost would stay unknown, because lower costs are found by comparison."""
    problem = record(SMALL, np.random.default_rng(1))
    vector, sizes = problem_vector(SMALL, problem), sizes_vector(SMALL, 0)
    distances, prices = np.zeros(3, dtype=np.int64), np.zeros(PRICES, dtype=np.int64)
    measure_distances(vector, distances)
    measure_prices(vector, sizes, distances, prices)
    edge = COARSE_BLOCKS
    surface = (np.arange(BLOCKS**2) * 37 & 255).reshape(BLOCKS, BLOCKS)[:edge, :edge].copy()
    y, x = divmod(GOAL, BLOCKS)
    expected = spread(prices, surface, y * edge + x, np.zeros_like(surface))

    bits = problem_payload(SMALL, problem)
    constant = f"{bits.shape().size}'d{bits.as_bits()}"
    bench = BENCH.replace("PROBLEM", constant).replace("GOAL", str(GOAL))
    text = convert(Wavefront(SMALL), "wavefront") + bench
    program = build_icarus(BuildCache(tmp_path), text, ["bench"])
    done = subprocess.run(["vvp", "-n", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == [str(expected), str(spreading(edge, 0, expected))]


def test_every_memory_and_read_port_begins_with_zeros():
    text = convert(Wavefront(SMALL), "wavefront")
    marked = len(re.findall(r"\(\* no_rw_check", text))
    ports = len(re.findall(r"reg .*\b_\d+_;", text))
    assert (marked, ports) == (2, 2)
    zeroed = with_zeros(text)
    assert zeroed.count("initial for (") == marked
    assert len(re.findall(r"initial _\d+_ = 0;", zeroed)) == ports
