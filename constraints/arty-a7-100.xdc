# Digilent Arty A7-100, XC7A100T in CSG324, for the plain Verilog of a chip at the board's clock.
# Planner core: pathgene verilog --top chip --set core=planner (3 Mbaud)
# Paper core: pathgene verilog --top chip (3 Mbaud)
set_property LOC E3 [get_ports "clk"]
set_property IOSTANDARD "LVCMOS33" [get_ports "clk"]
create_clock -name clk -period 10 [get_ports "clk"]
# Button BTN0, high when pressed.
set_property LOC D9 [get_ports "rst"]
set_property IOSTANDARD "LVCMOS33" [get_ports "rst"]
# USB bridge, FT2232HQ.
set_property LOC A9 [get_ports "rx"]
set_property IOSTANDARD "LVCMOS33" [get_ports "rx"]
set_property LOC D10 [get_ports "tx"]
set_property IOSTANDARD "LVCMOS33" [get_ports "tx"]
set_property CFGBVS VCCO [current_design]
set_property CONFIG_VOLTAGE 3.3 [current_design]
