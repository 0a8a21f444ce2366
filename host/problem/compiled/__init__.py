"""Kernels for small parts of rasters and maps, where NumPy takes longer to call than to compute."""
