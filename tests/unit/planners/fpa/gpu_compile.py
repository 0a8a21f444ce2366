"""Compile the kernel of the GPU engine to PTX, without a GPU; print the PTX's version line.

Exits with 3 if numba's CUDA lacks its compiler.
"""

import sys
from types import SimpleNamespace

import numba.cuda.dispatcher
import numpy as np
from numba import cuda, typeof, types

from host.evaluation.constants import Constants
from host.planners.fpa.cuda import iteration_kernel
from host.planners.fpa.steps import Pollination


CAPABILITY = 9, 0


def main():
    try:
        from numba.cuda.cudadrv.nvvm import NVVM

        NVVM()
    except Exception as error:
        print(error)
        return 3
    # Device functions are compiled for the present GPU, of which there is none.
    numba.cuda.dispatcher.get_current_device = lambda: SimpleNamespace(
        compute_capability=CAPABILITY
    )
    constants = Constants(
        **{name: 1.0 if kind is float else 1 for name, kind in Constants.__annotations__.items()}
    )
    parameters = Pollination(np.uint64(1), 500, 0.5, 0.25, 0.02)

    def array(kind, dimensions):
        return types.Array(kind, dimensions, "C")

    f, i, b = types.float64, types.int64, types.uint8
    signature = types.void(
        typeof(parameters),
        i,
        types.boolean,
        array(f, 3),
        array(f, 1),
        array(f, 3),
        array(f, 1),
        array(b, 1),
        array(f, 2),
        array(f, 1),
        array(b, 1),
        typeof(constants),
        array(i, 2),
        array(i, 1),
        i,
        array(f, 2),
        array(f, 3),
    )
    ptx, _ = cuda.compile_ptx(iteration_kernel(8), signature, cc=CAPABILITY)
    print(*(line for line in ptx.splitlines() if line.startswith((".version", ".target"))))
    print(ptx.count(".shared"), "shared", ptx.count("bar.sync"), "barriers")
    return 0


if __name__ == "__main__":
    sys.exit(main())
