"""Small building blocks of gateware, independent of paths, maps and commands."""
