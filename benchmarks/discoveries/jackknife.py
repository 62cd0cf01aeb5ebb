"""Standard errors of statistics whose distribution is not known."""

import numpy as np
from numpy.typing import ArrayLike


def jackknife_error(without_each: ArrayLike) -> float:
    """Standard error of a statistic from its values (blocks,) without each block of the data (Tukey 1958)."""
    values = np.asarray(without_each, dtype=float)
    return float(np.sqrt((values.size - 1) * np.var(values)))
