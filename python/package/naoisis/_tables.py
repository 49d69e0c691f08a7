"""CSV tables as columns."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np


class Columns(Mapping[str, np.ndarray]):
    """Columns by name, in order."""

    def __init__(self, columns: Mapping[str, np.ndarray]):
        self._columns = dict(columns)

    def __getitem__(self, name: str) -> np.ndarray:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)


def columns_of(table: Iterable[str]) -> dict[str, np.ndarray]:
    """The columns of a CSV table, whose first line has their names."""
    lines = list(csv.reader(table))
    if not lines:
        raise ValueError("there is nothing in the table; expected a line with the names of its columns")
    header = lines.pop(0)
    return {name: column_of(cells) for name, cells in zip(header, zip(*lines) if lines else ([] for _ in header))}


def column_of(cells: Sequence[str]) -> np.ndarray:
    """The cells as whole numbers, as numbers, or else as texts. An empty cell among numbers is NaN."""
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
