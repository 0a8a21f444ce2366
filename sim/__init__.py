"""Bit-exact software model of the chip, and simulated boards that run its Verilog."""
