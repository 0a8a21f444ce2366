"""Compile the kernel of the GPU engine to PTX, without a GPU; print the PTX's version line.

Exits with 3 if numba's CUDA lacks its compiler.
"""

import sys
from types import SimpleNamespace

import numba.cuda.dispatcher
import numpy as np
from numba import cuda, typeof, types

from pathgene.host.evaluation.constants import Constants
from pathgene.host.planners.fpa.cuda import table
from pathgene.host.planners.fpa.gpu_kernel import pollination_kernel, widest
from pathgene.host.planners.fpa.steps import Pollination


CAPABILITY = 9, 0


def main():
    try:
        from numba.cuda.cudadrv.nvvm import NVVM

        NVVM()
    except Exception as error:
        print(error)
        return 3
    # Device functions are compiled for the current GPU, and there is none.
    numba.cuda.dispatcher.get_current_device = lambda: SimpleNamespace(
        compute_capability=CAPABILITY
    )
    constants = Constants(
        **{name: 1.0 if kind is float else 1 for name, kind in Constants.__annotations__.items()}
    )
    parameters = Pollination(np.uint64(1), 500, 0.5, 0.25, 0.02)

    def array(kind, dimensions):
        return types.Array(kind, dimensions, "C")

    f, i = types.float64, types.int64
    signature = types.void(
        *(i, i, i, i),
        *(typeof(table([parameters])), typeof(table([constants])), array(f, 3)),
        *(array(f, 1), array(i, 1), array(f, 1), array(i, 1), array(types.int32, 2)),
        *(array(f, 5), array(f, 3), i, array(types.uint8, 2), array(i, 1), array(i, 2)),
        array(f, 3),
    )
    kernel = pollination_kernel(8, widest(8, 15, 128), 128)
    ptx, _ = cuda.compile_ptx(kernel, signature, cc=CAPABILITY)
    print(*(line for line in ptx.splitlines() if line.startswith((".version", ".target"))))
    print(ptx.count(".shared"), "shared", ptx.count("bar.sync"), "barriers")
    return 0


if __name__ == "__main__":
    sys.exit(main())
