"""The one solver of linear systems: Cholesky's factorisation of a small positive definite matrix, in
place ([1]_ section 4.2).

References
----------
.. [1] G. H. Golub and C. F. Van Loan (2013), Matrix Computations, 4th edition, Johns Hopkins.
"""

from __future__ import annotations

import math

from workbench.compiled import inner

__all__ = ["LEAST_PIVOT", "factorise", "substitute"]

LEAST_PIVOT = 1e-12
"""Least square of a pivot of a matrix that is positive definite but for rounding."""


@inner
def factorise(matrix, least):  # type: ignore[no-untyped-def]
    """Replace the lower triangle of a matrix A by its factor L, A = L L', with inverse pivots on the
    diagonal.

    Parameters
    ----------
    matrix : (n, n)
        A in, L out. What stands above the diagonal is not read.
    least : float
        A smaller square of a pivot is replaced by this, so that rounding takes no root of less
        than 0.

    Returns
    -------
    bool
        Whether no pivot was replaced: whether A is positive definite.
    """
    definite = True
    n = matrix.shape[0]
    for j in range(n):
        value = matrix[j, j]
        for m in range(j):
            value -= matrix[j, m] * matrix[j, m]
        if not value > least:
            definite = False
            value = least
        matrix[j, j] = 1.0 / math.sqrt(value)
        for i in range(j + 1, n):
            value = matrix[i, j]
            for m in range(j):
                value -= matrix[i, m] * matrix[j, m]
            matrix[i, j] = value * matrix[j, j]
    return definite


@inner
def substitute(factor, right, out):  # type: ignore[no-untyped-def]
    """Solve L L' out = right by forward and back substitution; out (n,) may be right itself."""
    n = right.shape[0]
    for i in range(n):
        value = right[i]
        for m in range(i):
            value -= factor[i, m] * out[m]
        out[i] = value * factor[i, i]
    for i in range(n - 1, -1, -1):
        value = out[i]
        for m in range(i + 1, n):
            value -= factor[m, i] * out[m]
        out[i] = value * factor[i, i]
