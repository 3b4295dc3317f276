"""Adjustment of p values for multiple comparisons."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def holm(p: ArrayLike) -> NDArray[np.float64]:
    """p values adjusted by Holm's step-down procedure (Holm 1979), which bounds the family-wise error rate.

    Args:
        p: p values of one family, (n,). NaN is no test: it stays NaN and does not enlarge the family.

    Returns:
        Adjusted p values, (n,), at most 1, never below the given ones, in the given order.
    """
    values = np.asarray(p, dtype=np.float64)
    adjusted = np.full(values.shape, np.nan)
    tested = np.flatnonzero(~np.isnan(values))
    order = tested[np.argsort(values[tested], kind="stable")]
    factors = np.arange(len(order), 0, -1)
    adjusted[order] = np.minimum(np.maximum.accumulate(values[order] * factors), 1.0)
    return adjusted
