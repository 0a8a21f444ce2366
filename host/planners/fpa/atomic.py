"""Atomic counters and ways to wait, for lock-free threads of kernels."""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


__all__ = ["fetch_add", "read", "sleep", "yield_core"]


@intrinsic
def fetch_add(_context: Any, _counter: Any, _amount: Any) -> Any:
    """Add ``amount`` to the first of ``counter``, (n,) int64, atomically; return its old value.

    For kernels on the CPU only. A thread that sees the sum also sees everything written before it.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        counter = context.make_array(signature.args[0])(context, builder, arguments[0])
        return builder.atomic_rmw("add", counter.data, arguments[1], "seq_cst")

    return types.int64(types.Array(types.int64, 1, "C"), types.int64), generate


@intrinsic
def read(_context: Any, _counter: Any) -> Any:
    """Return the current first element of ``counter``, (n,) int64, which other threads change."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        counter = context.make_array(signature.args[0])(context, builder, arguments[0])
        return builder.load_atomic(counter.data, "seq_cst", 8)

    return types.int64(types.Array(types.int64, 1, "C")), generate


@intrinsic
def yield_core(_context: Any) -> Any:
    """Yield the core to a waiting thread: POSIX ``sched_yield``."""
    return types.int32(), _call("sched_yield")


@intrinsic
def sleep(_context: Any, _microseconds: Any) -> Any:
    """Sleep for a number of microseconds, 0 to 999,999: POSIX ``usleep``."""
    return types.int32(types.uint32), _call("usleep", ir.IntType(32))


def _call(name: str, *of: ir.Type) -> Any:
    """Return a code generator for a call to a function of the C library, by its name."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        kind = ir.FunctionType(ir.IntType(32), of)
        function = builder.module.globals.get(name) or ir.Function(builder.module, kind, name)
        return builder.call(function, arguments)

    return generate
