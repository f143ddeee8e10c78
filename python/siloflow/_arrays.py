"""Columns of numbers as NumPy arrays."""

from dataclasses import dataclass

import numpy as np
import pandas as pd


def arrays(columns: dict) -> dict[str, np.ndarray]:
    """Returns one array per column: a row for each grain or contact; vectors have one number per axis."""
    found = {}
    for name, (dtype, components, data) in columns.items():
        numbers = np.frombuffer(data, dtype=dtype)
        found[name] = numbers.reshape(-1, components) if components > 1 else numbers
    return found


@dataclass(frozen=True)
class Frame:
    """The state of a run at one time. The tables are ``grains``, and ``contacts`` and ``wall_contacts`` if the scene keeps them."""

    step: int
    time: float  # s
    released: int
    inside: int
    out: int
    lost: int
    tables: dict[str, dict[str, np.ndarray]]

    @property
    def grains(self) -> dict[str, np.ndarray]:
        """Columns of the grains and wall grains as arrays."""
        return self.tables["grains"]

    def frame(self, table: str = "grains") -> pd.DataFrame:
        """Returns a table as a pandas DataFrame. Vectors become columns such as ``position_x``."""
        columns = {}
        for name, numbers in self.tables[table].items():
            if numbers.ndim == 1:
                columns[name] = numbers
            else:
                columns.update({f"{name}_{axis}": numbers[:, place] for place, axis in enumerate("xyz"[: numbers.shape[1]])})
        return pd.DataFrame(columns)
