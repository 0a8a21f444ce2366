"""Bit-exact integer software model of the gateware: the reference for the RTL."""
