"""``ga-fpga`` and ``ga-pc``: the genetic algorithm of *allaire-2008*, on the chip and on the PC."""
