"""Many runs of a scene: sweeps, and estimates of a figure with its error."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from siloflow._program import command, finish
from siloflow._ron import settings as _settings
from siloflow._scene import Scene, file_of, path_of


def sweep(file: str | os.PathLike[str], out: str | os.PathLike[str] | None = None, *, jobs: int | None = None) -> pd.DataFrame:
    """Runs a sweep file with ``siloflow sweep``, continues it where it was, and returns its table: means, standard errors and numbers of runs."""
    directory = Path(out) if out is not None else Path("out") / Path(file).stem
    more = [] if jobs is None else [f"--jobs={jobs}"]
    finish(command("sweep", os.fspath(file), "--out", os.fspath(directory), *more))
    return pd.read_csv(directory / "table.csv")


@dataclass(frozen=True)
class Estimate:
    """A figure with its error. ``refused`` has the reason if the wanted width was not reached; the numbers are then the best that there is."""

    figure: str
    value: float | None
    interval: tuple[float, float] | None
    confidence: float
    refused: str | None
    #: Everything that ``estimate.json`` has.
    record: dict[str, Any]

    def __str__(self) -> str:
        if self.value is None or self.interval is None:
            return f"{self.figure}: {self.refused}"
        half = 0.5 * (self.interval[1] - self.interval[0])
        return f"{self.figure} = {self.value:.6g} ± {half:.2g}" + (f" ({self.refused})" if self.refused else "")


def estimate(
    scene: Scene,
    figure: str,
    *,
    within: str | float | None = None,
    budget: str | None = None,
    grow: bool = False,
    size: Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] | None = None,
    settings: Mapping[str, Any] | None = None,
    **keys: Any,
) -> Estimate:
    """Runs a scene with seeds and softer grains until a figure is known ``within`` a width ("2%", or in its unit) or the ``budget`` ("10min") is used.

    With ``grow`` the radii of softer grains make up for overlaps. ``size`` has keys of the scene with values of a larger silo, which is compared
    (``record["size"]``).

    Returns the mean over seeds with its 95 % confidence interval (``siloflow estimate``). Continues where an earlier call with the same ``out`` was.
    """
    directory = Path(out) if out is not None else Path("out") / f"{path_of(scene).stem}-estimate"
    arguments = ["estimate", os.fspath(file_of(scene)), "--figure", figure, "--out", os.fspath(directory), "--json"]
    arguments += [] if within is None else ["--within", str(within)]
    arguments += [] if budget is None else ["--budget", budget]
    arguments += ["--grow"] if grow else []
    arguments += [f"--size={path}={value}" for path, value in _settings(size, {})]
    arguments += [f"--set={path}={value}" for path, value in _settings(settings, keys)]
    done = finish(command(*arguments), accepts_failure=True)
    record: dict[str, Any] = json.loads(done.stdout)
    interval = record.get("interval")
    return Estimate(
        figure,
        record.get("value"),
        None if interval is None else (interval[0], interval[1]),
        record.get("confidence", 0.95),
        record.get("refused"),
        record,
    )
