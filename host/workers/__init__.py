"""Tasks done in several processes, or on a Dask cluster."""

__all__ = ["LOCAL"]

#: The address of a scheduler that asks for a cluster of our own.
LOCAL = "local"
