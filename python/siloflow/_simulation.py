"""A simulation that is stepped from Python."""

import json
import os

import numpy as np
import pandas as pd

from siloflow._arrays import Frame, arrays
from siloflow._settings import settings as _settings
from siloflow._siloflow import Simulation as _Engine


class Simulation:
    """A simulation of a scene with grains; step zero, which evaluates the forces at the start, has run.

    Settings are those of :func:`siloflow.run`. A simulation writes no files. The arrays are copies of the state, in the order of the
    grains' ids. A simulation belongs to the thread that made it.
    """

    def __init__(self, scene: str | os.PathLike, *, threads: int = 1, settings: dict | None = None, **keys):
        self._engine = _Engine(scene, _settings(settings, keys), threads)

    def __repr__(self) -> str:
        return f"<Simulation: {self.time:.6g} s, {self.inside} grains, {self.status or 'goes on'}>"

    def advance(self, steps: int = 1) -> str | None:
        """Does this many steps, or fewer if the run ends. Returns the status."""
        self._engine.advance(steps)
        return self.status

    def advance_to(self, time: float) -> str | None:
        """Steps until a simulated time, s, or the end of the run. Returns the status."""
        self._engine.advance_to(time)
        return self.status

    @property
    def status(self) -> str | None:
        """Why the run has ended, such as ``empty`` or ``failed``; ``None`` while it goes on."""
        return self._engine.status()

    @property
    def failure(self) -> str | None:
        """The reason of a failure; ``None`` without one."""
        return self._engine.failure()

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._engine.time()

    @property
    def steps(self) -> int:
        """Number of completed steps."""
        return self._engine.steps()

    @property
    def dt(self) -> float:
        """The time step, s."""
        return self._engine.dt()

    @property
    def inside(self) -> int:
        """Number of grains inside: released, and neither out nor lost."""
        return self._engine.counts()[1]

    @property
    def out(self) -> int:
        """Number of grains that left through the outlet."""
        return self._engine.counts()[2]

    @property
    def totals(self) -> dict:
        """Totals over the grains: energies (J), largest speed (m/s), largest overlap ratio, coordination number."""
        return json.loads(self._engine.totals())

    @property
    def grains(self) -> dict[str, np.ndarray]:
        """Columns of the grains: id, species, radius (m), mass (kg), position (m), velocity (m/s)."""
        return arrays(self._engine.grains())

    @property
    def position(self) -> np.ndarray:
        """Centres of the grains, m, one row per grain."""
        return self.grains["position"]

    @property
    def velocity(self) -> np.ndarray:
        """Velocities of the grains, m/s, one row per grain."""
        return self.grains["velocity"]

    def frame(self) -> pd.DataFrame:
        """Returns the grains as a pandas DataFrame."""
        released, inside, out, lost = self._engine.counts()
        return Frame(self.steps, self.time, released, inside, out, lost, {"grains": self.grains}).frame()
