"""Linear programs, by the simplex method of HiGHS."""

from __future__ import annotations

import highspy
import numpy as np
from numpy.typing import NDArray


__all__ = ["minimised"]

Floats = NDArray[np.float64]


def minimised(costs: Floats, matrix: Floats, limits: Floats, bounds: Floats) -> Floats | None:
    """Return the variables x that minimize ``costs @ x`` with ``matrix @ x <= limits``.

    Parameters
    ----------
    costs : (n,) float64
    matrix, limits : (m, n) and (m,) float64
    bounds : (n, 2) float64
        Minimum and maximum of each variable; infinite for none.

    Returns
    -------
    ndarray or None
        (n,) float64, within the limits to 1e-7; None if there is no minimum.
    """
    rows, columns = matrix.shape
    program = highspy.HighsLp()
    program.num_row_, program.num_col_ = rows, columns
    program.col_cost_ = costs
    program.col_lower_, program.col_upper_ = bounds[:, 0].copy(), bounds[:, 1].copy()
    program.row_lower_, program.row_upper_ = np.full(rows, -np.inf), limits
    column, row = np.nonzero(matrix.T)
    sparse = program.a_matrix_
    sparse.format_ = highspy.MatrixFormat.kColwise
    sparse.num_row_, sparse.num_col_ = rows, columns
    sparse.start_ = np.searchsorted(column, np.arange(columns + 1)).astype(np.int32)
    sparse.index_, sparse.value_ = row.astype(np.int32), matrix[row, column]
    solver = highspy.Highs()
    solver.setOptionValue("output_flag", False)
    solver.passModel(program)
    solver.run()
    if solver.getModelStatus() != highspy.HighsModelStatus.kOptimal:
        return None
    return np.array(solver.getSolution().col_value)
