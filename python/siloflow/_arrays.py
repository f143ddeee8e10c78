"""Columns of numbers as NumPy arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import pandas as pd

#: A column as the compiled module gives it: type of its numbers, numbers of a row, bytes.
Column: TypeAlias = tuple[str, int, bytes]

#: An array of numbers.
Array: TypeAlias = npt.NDArray[Any]


def array(column: Column) -> Array:
    """Returns a column as an array that cannot be changed: a row for each grain or contact; vectors have one number per axis."""
    dtype, components, data = column
    numbers: Array = np.frombuffer(data, dtype=np.dtype(dtype))
    return numbers.reshape(-1, components) if components > 1 else numbers


def arrays(columns: Mapping[str, Column]) -> dict[str, Array]:
    """Returns one array per column."""
    return {name: array(column) for name, column in columns.items()}


def table(columns: Mapping[str, Array]) -> pd.DataFrame:
    """Returns columns as a pandas DataFrame. Vectors become columns such as ``position_x``."""
    flat: dict[str, Array] = {}
    for name, numbers in columns.items():
        if numbers.ndim == 1:
            flat[name] = numbers
        else:
            axes = "wxyz" if numbers.shape[1] == 4 else "xyz"
            flat.update({f"{name}_{axis}": numbers[:, place] for place, axis in enumerate(axes[: numbers.shape[1]])})
    return pd.DataFrame(flat)


@dataclass(frozen=True)
class Frame:
    """The state of a run at one time. The tables are ``grains``, and ``contacts`` and ``wall_contacts`` if the scene keeps them."""

    step: int
    time: float  # s
    released: int
    inside: int
    out: int
    lost: int
    tables: dict[str, dict[str, Array]]

    @property
    def grains(self) -> dict[str, Array]:
        """Columns of the grains and wall grains as arrays."""
        return self.tables["grains"]

    def frame(self, table_name: str = "grains") -> pd.DataFrame:
        """Returns a table as a pandas DataFrame. Vectors become columns such as ``position_x``."""
        return table(self.tables[table_name])
