"""A counter that threads share, for kernels that hold no lock."""

from typing import Any

from numba import types
from numba.extending import intrinsic


__all__ = ["fetch_add"]


@intrinsic
def fetch_add(_context: Any, _counter: Any, _amount: Any) -> Any:
    """Add ``amount`` to the first of ``counter``, (n,) int64, at once; return what it was before.

    For kernels on the CPU only.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        counter = context.make_array(signature.args[0])(context, builder, arguments[0])
        return builder.atomic_rmw("add", counter.data, arguments[1], "seq_cst")

    return types.int64(types.Array(types.int64, 1, "C"), types.int64), generate
