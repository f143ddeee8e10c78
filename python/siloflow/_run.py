"""Runs of scenes, and their run directories."""

import io
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

import pandas as pd

from siloflow._arrays import Frame, arrays
from siloflow._settings import settings as _settings
from siloflow._siloflow import Frames, SceneError


class Run:
    """A run directory. Runs that go on or were killed are read as far as their files go."""

    def __init__(self, directory: str | os.PathLike):
        self.path = Path(directory)
        if not (self.path / "scene.ron").is_file():
            raise FileNotFoundError(f"{self.path} is no run directory: it has no scene.ron")

    def __repr__(self) -> str:
        return f"Run({str(self.path)!r})"

    @cached_property
    def summary(self) -> dict:
        """The results, ``summary.json``; the file has them once the run has ended."""
        return json.loads((self.path / "summary.json").read_text(encoding="utf-8"))

    @property
    def scene(self) -> str:
        """The scene with all settings."""
        return (self.path / "scene.ron").read_text(encoding="utf-8")

    @property
    def tables(self) -> list[str]:
        """Names of the tables that the run has, for ``run["name"]``."""
        return sorted(path.stem for path in self.path.glob("*.csv"))

    def __getitem__(self, table: str) -> pd.DataFrame:
        """Returns a CSV file of the run as a pandas DataFrame: ``run["profiles"]`` is ``profiles.csv``."""
        path = self.path / f"{table}.csv"
        if not path.is_file():
            raise KeyError(f"{self.path} has no {table}.csv; it has {', '.join(self.tables) or 'no tables'}")
        text = path.read_text(encoding="utf-8")
        # The last line of a killed run may not be whole.
        return pd.read_csv(io.StringIO(text[: text.rfind("\n") + 1]))

    @property
    def series(self) -> pd.DataFrame:
        """The run over time, ``series.csv``."""
        return self["series"]

    @property
    def state(self) -> pd.DataFrame:
        """The grains at the end, ``state.csv``."""
        return self["state"]

    def header(self) -> dict:
        """Returns the facts that all frames share: species, periodic sides, walls, units of registered columns."""
        return json.loads(self._frames().header())

    def frames(self) -> Iterator[Frame]:
        """Yields the frames of ``frames.bin``, which a scene with pictures or ``data_frames`` keeps."""
        for step, time, counts, tables in self._frames():
            yield Frame(step, time, *counts, {name: arrays(columns) for name, columns in tables.items()})

    def _frames(self) -> Frames:
        path = self.path / "frames.bin"
        if not path.is_file():
            raise FileNotFoundError(f"{self.path} has no frames.bin: run its scene with data_frames=(interval: 0.1)")
        return Frames(path)


class RunFailed(RuntimeError):
    """A simulation that failed: it became unstable, lost a grain or could not release one. ``run`` is the run directory."""

    def __init__(self, message: str, run: Run):
        super().__init__(message)
        self.run = run


def run(scene: str | os.PathLike, out: str | os.PathLike | None = None, *, force: bool = False, threads: int = 1,
        settings: dict | None = None, **keys) -> Run:
    """Runs a scene to its end in a process of its own, and returns the run.

    ``out`` is the run directory, ``out/<scene name>`` by default; an earlier run in it is replaced only with ``force``. Settings change
    keys of the scene: ``run(scene, spawner__count=200)``, or ``run(scene, settings={"fill[0].spacing": 0.04})``. Raises ``SceneError`` for
    a wrong scene or setting, and ``RunFailed`` if the simulation failed.
    """
    directory = Path(out) if out is not None else Path("out") / Path(scene).stem
    command = [sys.executable, "-m", "siloflow", "--quiet", "run", os.fspath(scene), "--out", os.fspath(directory), f"--threads={threads}"]
    command += [f"--set={path}={value}" for path, value in _settings(settings, keys)] + ["--force"] * force
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, encoding="utf-8", errors="replace", check=False)
    message = done.stderr.strip()
    if done.returncode == 0:
        return Run(directory)
    if done.returncode == 1:
        raise RunFailed(message, Run(directory))
    if done.returncode == 2:
        raise SceneError(message)
    if done.returncode in (130, -2):
        raise KeyboardInterrupt
    raise RuntimeError(f"the run of {os.fspath(scene)} was stopped, status {done.returncode}; its files so far are in {directory}")
