"""Bit-exact software model of the gateware: integers only, the standard the RTL is held to."""
