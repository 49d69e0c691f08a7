"""Infos of many rows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

NESTED = ("drawn", "statistics")


def vector_info(of_rows: Mapping[int, Mapping[str, Any]], rows: int, *, as_objects: bool = False) -> dict[str, Any]:
    """The infos of some rows as arrays of all rows: beside each array ``name`` is ``_name``, true for rows that have a value. Values that were drawn
    stay as they are, so that they can be set again."""
    info: dict[str, Any] = {}
    for name in dict.fromkeys(name for of_row in of_rows.values() for name in of_row):
        values = {row: of_row[name] for row, of_row in of_rows.items() if name in of_row}
        has = np.zeros(rows, np.bool_)
        has[list(values)] = True
        info[f"_{name}"] = has
        first = next(iter(values.values()))
        if name in NESTED and isinstance(first, Mapping):
            info[name] = vector_info(values, rows, as_objects=name == "drawn")
            continue
        dtype: Any = object
        if name == "match_seed":
            dtype = np.uint64
        elif not as_objects and all(
            isinstance(value, (int, float)) and not isinstance(value, bool) for value in values.values()
        ):
            dtype = np.float64
        array = np.full(rows, None, object) if dtype is object else np.zeros(rows, dtype)
        for row, value in values.items():
            array[row] = value
        info[name] = array
    return info
