"""Small building blocks of gateware that know nothing of paths, maps or commands."""
