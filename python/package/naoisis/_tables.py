"""Tables of comma-separated values as columns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def column_of(cells: Sequence[str]) -> np.ndarray:
    """The cells as whole numbers, as numbers, or else as texts. An empty cell among numbers is not a number."""
    try:
        return np.array([int(cell) for cell in cells], dtype=np.uint64 if _is_large(cells) else np.int64)
    except ValueError:
        pass
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells], dtype=np.float64)
    except ValueError:
        return np.array(cells, dtype=object)


def _is_large(cells: Sequence[str]) -> bool:
    return any(int(cell) >= 2**63 for cell in cells)
