`timescale 1ns / 1ns

// Clock and board of a chip under Icarus Verilog. BOARD_TOP is the module of the chip; BOARD_BYTES
// is defined if its line is a byte-wide port.
module board_bench;
    reg clk = 1'b0;
    reg rst = 1'b1;
    reg rx = 1'b1;
    reg rx_valid = 1'b0;
    reg [7:0] rx_data = 8'd0;
    wire tx;
    wire tx_valid;
    wire [7:0] tx_data;
    wire rx_ready;

    `BOARD_TOP chip (
        .clk(clk),
        .rst(rst),
`ifdef BOARD_BYTES
        .rx_data(rx_data),
        .rx_valid(rx_valid),
        .rx_ready(rx_ready),
        .tx_data(tx_data),
        .tx_valid(tx_valid),
        .tx_ready(1'b1)
    );
    assign tx = 1'b1;
`else
        .rx(rx),
        .tx(tx)
    );
    assign {tx_valid, tx_data, rx_ready} = 10'd0;
`endif

    // Inputs change at the falling edge, half a cycle before the chip reads them.
    always begin
        #1 clk = 1'b1;
        #1 clk = 1'b0;
        {rst, rx, rx_valid, rx_data} = $board_clock({tx, tx_valid, tx_data, rx_ready});
    end

    reg [8 * 4096 - 1:0] trace;
    initial if ($value$plusargs("trace=%s", trace)) begin
        $dumpfile(trace);
        $dumpvars(0, chip);
    end
endmodule
