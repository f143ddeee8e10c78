"""Runs of scenes, and their run directories."""

from __future__ import annotations

import html
import io
import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas as pd

from siloflow._arrays import Frame, arrays
from siloflow._program import command, finish
from siloflow._ron import settings as _settings
from siloflow._scene import Scene, file_of, path_of
from siloflow._siloflow import Frames


class Figure:
    """A figure as SVG. A notebook shows it."""

    def __init__(self, svg: str) -> None:
        self.svg = svg

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the SVG into a file."""
        Path(path).write_text(self.svg, encoding="utf-8")


class Page:
    """A page of HTML. A notebook shows it in a frame."""

    def __init__(self, text: str, height: int) -> None:
        self.text = text
        self.height = height

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{html.escape(self.text)}" style="width: 100%; height: {self.height}px; border: 0"></iframe>'

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page into a file, for a browser."""
        Path(path).write_text(self.text, encoding="utf-8")


class Run:
    """A run directory. Runs that go on or were killed are read as far as their files go. A notebook shows its report with the player."""

    def __init__(self, directory: str | os.PathLike[str]) -> None:
        self.path = Path(directory)
        if not (self.path / "scene.ron").is_file():
            raise FileNotFoundError(f"{self.path} is no run directory: it has no scene.ron")

    def __repr__(self) -> str:
        return f"Run({str(self.path)!r})"

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The results, ``summary.json``; the file has them once the run has ended."""
        found: dict[str, Any] = json.loads((self.path / "summary.json").read_text(encoding="utf-8"))
        return found

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

    def header(self) -> dict[str, Any]:
        """Returns the facts that all frames share: species, periodic sides, walls, units of registered columns."""
        found: dict[str, Any] = json.loads(self._frames().header())
        return found

    def frames(self) -> Iterator[Frame]:
        """Yields the frames of ``frames.bin``, which a scene with pictures or ``data_frames`` keeps."""
        for step, at, counts, tables in self._frames():
            yield Frame(step, at, *counts, {name: arrays(columns) for name, columns in tables.items()})

    def _frames(self) -> Frames:
        path = self.path / "frames.bin"
        if not path.is_file():
            raise FileNotFoundError(f"{self.path} has no frames.bin: run its scene with data_frames=(interval: 0.1)")
        return Frames(path)

    def plot(self, what: str = "discharge", *others: Run | str | os.PathLike[str]) -> Figure:
        """Returns a figure of ``siloflow plot``: ``discharge``, ``energy``, ``walls``, ``bands``, ``profiles`` and others; with ``others`` beside each other."""
        runs = [os.fspath(one.path if isinstance(one, Run) else one) for one in (self, *others)]
        with tempfile.TemporaryDirectory() as here:
            out = Path(here) / "figures"
            finish(command("plot", *runs, "--what", what, "--out", os.fspath(out)))
            figures = sorted(out.glob("*.svg"))
            if not figures:
                raise ValueError(f"the run {self.path} has nothing to plot for {what}")
            return Figure(figures[0].read_text(encoding="utf-8"))

    def show(self, height: int = 900) -> Page:
        """Returns the report of ``siloflow report``, which has the player and all curves, as a page for a notebook or a browser."""
        with tempfile.TemporaryDirectory() as here:
            out = Path(here) / "report.html"
            finish(command("report", os.fspath(self.path), "--out", os.fspath(out)))
            return Page(out.read_text(encoding="utf-8"), height)

    def _repr_html_(self) -> str:
        return self.show()._repr_html_()


class RunFailed(RuntimeError):
    """A simulation that failed: it became unstable, lost a grain or could not release one. ``run`` is the run directory."""

    def __init__(self, message: str, run: Run) -> None:
        super().__init__(message)
        self.run = run


def run(
    scene: Scene,
    out: str | os.PathLike[str] | None = None,
    *,
    force: bool = False,
    threads: int = 1,
    progress: bool = False,
    settings: Mapping[str, Any] | None = None,
    **keys: Any,
) -> Run:
    """Runs a scene to its end in a process of its own, and returns the run.

    ``scene`` is a path, the text of a scene, or a dictionary of its keys. ``out`` is the run directory, ``out/<scene name>`` by default; an
    earlier run in it is replaced only with ``force``. Settings change keys of the scene: ``run(scene, spawner__count=200)``, or ``run(scene,
    settings={"fill[0].spacing": 0.04})``. With ``progress``, a line tells how far the run is. Raises ``SceneError`` for a wrong scene or setting,
    and ``RunFailed`` if the simulation failed.
    """
    directory = Path(out) if out is not None else Path("out") / path_of(scene).stem
    arguments = ["run", os.fspath(file_of(scene)), "--out", os.fspath(directory), f"--threads={threads}"]
    arguments += [f"--set={path}={value}" for path, value in _settings(settings, keys)] + ["--force"] * force
    done = finish(command(*arguments), (directory if progress else None), accepts_failure=True)
    if done.returncode == 1:
        raise RunFailed(done.stderr.strip(), Run(directory))
    return Run(directory)
