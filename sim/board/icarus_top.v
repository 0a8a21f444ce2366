`timescale 1ns / 1ns

// Clock and board of a chip under Icarus Verilog. BOARD_TOP is the module of the chip.
module board_bench;
    reg clk = 1'b0;
    reg rst = 1'b1;
    reg rx = 1'b1;
    wire tx;

    `BOARD_TOP chip (
        .clk(clk),
        .rst(rst),
        .rx(rx),
        .tx(tx)
    );

    // Inputs change at the falling edge, half a cycle before the chip reads them.
    always begin
        #1 clk = 1'b1;
        #1 clk = 1'b0;
        {rst, rx} = $board_clock(tx);
    end

    reg [8 * 4096 - 1:0] trace;
    initial if ($value$plusargs("trace=%s", trace)) begin
        $dumpfile(trace);
        $dumpvars(0, chip);
    end
endmodule
