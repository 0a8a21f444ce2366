// Arithmetic of the chips with the planner core on an ECP5, as maps for Yosys's techmap.

// Adder or subtractor with an input that says which, of pathgene.hdl.boards.ecp5_cells.
module ADD_OR_SUBTRACT (first, second, subtracts, total);
  parameter WIDTH = 1;

  input [WIDTH-1:0] first, second;
  input subtracts;
  output [WIDTH-1:0] total;
  wire [WIDTH-1:0] differences, carries;

  \$alu #(
    .A_SIGNED(0), .B_SIGNED(0), .A_WIDTH(WIDTH), .B_WIDTH(WIDTH), .Y_WIDTH(WIDTH)
  ) alu (
    .A(first), .B(second), .BI(subtracts), .CI(subtracts), .Y(total), .X(differences), .CO(carries)
  );
endmodule

// Carry chain that begins with a bit of its own, whose two equal addends are the carry: nextpnr
// feeds a carry in by a whole cell, two bits, even where it is constant. That bit and a last one
// that gives the carry out take the place of padding where there is some.
(* techmap_celltype = "$alu" *)
module _80_ecp5_alu (A, B, CI, BI, X, Y, CO);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 1;
  parameter B_WIDTH = 1;
  parameter Y_WIDTH = 1;

  (* force_downto *)
  input [A_WIDTH-1:0] A;
  (* force_downto *)
  input [B_WIDTH-1:0] B;
  (* force_downto *)
  output [Y_WIDTH-1:0] X, Y, CO;
  input CI, BI;

  // Fewer bits are left to lookup tables, and 5 and 6 bits to Yosys's own chains.
  wire _TECHMAP_FAIL_ = Y_WIDTH <= 6;

  (* force_downto *)
  wire [Y_WIDTH-1:0] A_buf, B_buf;
  \$pos #(.A_SIGNED(A_SIGNED), .A_WIDTH(A_WIDTH), .Y_WIDTH(Y_WIDTH)) A_conv (.A(A), .Y(A_buf));
  \$pos #(.A_SIGNED(B_SIGNED), .A_WIDTH(B_WIDTH), .Y_WIDTH(Y_WIDTH)) B_conv (.A(B), .Y(B_buf));

  // Cells: two bits each; the last bit of all is only there for the carry out.
  localparam CELLS = Y_WIDTH / 2 + 1;
  localparam BITS = 2 * CELLS;

  wire [BITS-1:0] first = {A_buf, CI};
  wire [BITS-1:0] second = {B_buf, CI};
  wire [BITS-1:0] inverts = {{Y_WIDTH{BI}}, 1'b0};
  wire [BITS-1:0] sum;
  wire [CELLS:0] carry;
  assign carry[0] = 1'bx;

  genvar i;
  generate
    for (i = 0; i < CELLS; i = i + 1) begin : slice
      CCU2C #(
        .INIT0(16'b1001011010101010), .INIT1(16'b1001011010101010),
        .INJECT1_0("NO"), .INJECT1_1("NO")
      ) bits (
        .CIN(carry[i]), .COUT(carry[i+1]),
        .A0(first[2*i]), .B0(second[2*i]), .C0(inverts[2*i]), .D0(1'b1), .S0(sum[2*i]),
        .A1(first[2*i+1]), .B1(second[2*i+1]), .C1(inverts[2*i+1]), .D1(1'b1), .S1(sum[2*i+1])
      );
    end

    for (i = 0; i < Y_WIDTH; i = i + 1) begin : carries
      // Bit i of the operands is bit i + 1 of the chain.
      if (i + 2 < BITS && i == Y_WIDTH - 1)
        assign CO[i] = sum[i+2];
      else if (i % 2 == 0)
        assign CO[i] = carry[i/2+1];
      else
        assign CO[i] = (A_buf[i] & (B_buf[i] ^ BI)) | (carry[i/2+1] & (A_buf[i] | (B_buf[i] ^ BI)));
    end
  endgenerate

  assign Y = sum[Y_WIDTH:1];
  assign X = A_buf ^ (B_buf ^ {Y_WIDTH{BI}});
endmodule

// First cell of such a chain, with two equal addends. Synthesis makes its carry in, which has no
// effect, a constant; only where there is none does nextpnr leave the feeding cell out. In the first
// cell of a chain of Yosys's own map, the carry in is added to two addends and stays.
(* techmap_celltype = "CCU2C" *)
module _81_ecp5_first (
  input CIN, A0, B0, C0, D0, A1, B1, C1, D1,
  output S0, S1, COUT
);
  parameter INIT0 = 0;
  parameter INIT1 = 0;
  parameter INJECT1_0 = "NO";
  parameter INJECT1_1 = "NO";
  parameter _TECHMAP_CONSTMSK_CIN_ = 0;
  parameter _TECHMAP_CONSTVAL_CIN_ = 0;
  parameter _TECHMAP_CONNMAP_A0_ = 0;
  parameter _TECHMAP_CONNMAP_B0_ = 0;

  wire _TECHMAP_FAIL_ = _TECHMAP_CONSTMSK_CIN_ !== 1'b1 || _TECHMAP_CONSTVAL_CIN_ === 1'bx
    || _TECHMAP_CONNMAP_A0_ !== _TECHMAP_CONNMAP_B0_;

  CCU2C #(
    .INIT0(INIT0), .INIT1(INIT1), .INJECT1_0(INJECT1_0), .INJECT1_1(INJECT1_1)
  ) _TECHMAP_REPLACE_ (
    .CIN(1'bx), .COUT(COUT),
    .A0(A0), .B0(B0), .C0(C0), .D0(D0), .S0(S0),
    .A1(A1), .B1(B1), .C1(C1), .D1(D1), .S1(S1)
  );
endmodule
