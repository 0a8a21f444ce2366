"""Tasks done in several processes, or on a Dask cluster."""

__all__ = ["LOCAL"]

#: The address of a scheduler that stands for a local cluster.
LOCAL = "local"
