"""A simulation that Python steps."""

from __future__ import annotations

import json
import os
import sys
import time as clock
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from siloflow._arrays import Array, array, arrays, table
from siloflow._ron import settings as _settings
from siloflow._scene import Scene, path_of, text_of
from siloflow._siloflow import Simulation as _Engine


class Simulation:
    """A simulation of a scene with grains, stepped from Python. It writes no files.

    ``scene`` is a path, the text of a scene, or a dictionary of its keys; settings are those of :func:`siloflow.run`. With ``state`` the
    simulation goes on from a file of :meth:`save`, a checkpoint of a run of the same scene, or the latest one in a run directory.

    Arrays have a row for each grain that is present, in the order of the grains' ids. They are copies, and cannot be changed; the state is changed by
    assignment: ``simulation.velocity = simulation.velocity * 0.5``. All numbers are SI.

    While it advances, other threads of Python run, and Ctrl-C arrives. A second thread that uses a simulation at that time gets a ``RuntimeError``.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        threads: int = 1,
        state: str | os.PathLike[str] | None = None,
        settings: Mapping[str, Any] | None = None,
        **keys: Any,
    ) -> None:
        self._engine = _Engine(path_of(scene), text_of(scene), _settings(settings, keys), threads, state)
        self._calls: list[tuple[int, Callable[[Simulation], object]]] = []

    def __repr__(self) -> str:
        return f"<Simulation: {self.time:.6g} s, {self.inside} grains, {self.status or 'goes on'}>"

    def _repr_html_(self) -> str:
        return f"<figure>{self._engine.picture()}<figcaption>{self.time:.6g} s, {self.inside} grains inside, {self.out} out</figcaption></figure>"

    def picture(self) -> str:
        """Returns a picture of the grains as they are, as SVG, with the scene's ``pictures``."""
        return self._engine.picture()

    # Time

    def advance(self, steps: int = 1, *, progress: bool = False) -> str | None:
        """Does this many steps, or fewer if the run ends. Returns the status."""
        return self._advance_to_step(self.steps + steps, progress)

    def advance_to(self, time: float, *, progress: bool = False) -> str | None:
        """Steps until a simulated time, s, or the end of the run. Returns the status."""
        return self._advance_to_step(self._engine.steps_at(time), progress)

    def every(self, steps: int, call: Callable[[Simulation], object]) -> Callable[[Simulation], object]:
        """Calls ``call(simulation)`` after each step whose number is a multiple of ``steps``, from now on. Returns ``call``, for :meth:`forget`."""
        if steps < 1:
            raise ValueError(f"every {steps} steps: at least 1 is needed")
        self._calls.append((steps, call))
        return call

    def forget(self, call: Callable[[Simulation], object]) -> None:
        """Calls ``call`` no more."""
        self._calls = [(steps, one) for steps, one in self._calls if one is not call]

    def _advance_to_step(self, target: int, progress: bool) -> str | None:
        start = self.steps
        told = clock.monotonic()
        chunk = 1
        try:
            while self.status is None and self.steps < target:
                now = self.steps
                # The next step with a call, and for the progress no more than about a fifth of a second.
                stops = [(now // steps + 1) * steps for steps, _ in self._calls] + [target] + [now + chunk] * progress
                began = clock.monotonic()
                self._engine.advance(min(stops) - now)
                chunk = max(1, chunk * 2 if clock.monotonic() - began < 0.1 else chunk // 2)
                if self._calls:
                    self._engine.stop_pushing()
                for steps, call in list(self._calls):
                    if self.steps % steps == 0 and self.steps > now:
                        call(self)
                if progress and clock.monotonic() - told > 0.25:
                    told = clock.monotonic()
                    share = (self.steps - start) / max(1, target - start)
                    print(f"\r{self.time:.4g} s, {self.inside} grains inside, {self.out} out, {share:.0%} ", end="", file=sys.stderr, flush=True)
        finally:
            self._engine.stop_pushing()
            if progress:
                print(f"\r{self!r}", file=sys.stderr)
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
    def scene(self) -> str:
        """The text of the scene, with all settings."""
        return self._engine.scene()

    # Grains

    @property
    def inside(self) -> int:
        """Number of grains inside: released, and neither out, lost nor removed."""
        return self._engine.counts()[1]

    @property
    def out(self) -> int:
        """Number of grains that left through the outlet."""
        return self._engine.counts()[2]

    @property
    def grains(self) -> dict[str, Array]:
        """All columns of the grains: id, species, radius (m), mass (kg), position (m), velocity (m/s), force (N), spin (rad/s) and orientation where they have them."""
        return {name: self[name] for name in self._engine.column_names()}

    def __getitem__(self, column: str) -> Array:
        """Returns one column of the grains."""
        return array(self._engine.column(column))

    @property
    def id(self) -> Array:
        """Ids of the grains."""
        return self["id"]

    @property
    def species(self) -> Array:
        """Species of the grains."""
        return self["species"]

    @property
    def radius(self) -> Array:
        """Radii, m; of shaped grains those of spheres (discs) of equal volume (area)."""
        return self["radius"]

    @property
    def mass(self) -> Array:
        """Masses, kg."""
        return self["mass"]

    @property
    def force(self) -> Array:
        """Sums of the forces at the last step, N, one row per grain."""
        return self["force"]

    @property
    def orientation(self) -> Array:
        """Orientations of shaped grains: angles in the plane, rad, quaternions w, x, y, z in solid space; NaN for round ones."""
        return self["orientation"]

    @property
    def position(self) -> Array:
        """Centres of the grains, m, one row per grain. Assignment puts them elsewhere; what this changes in energy is booked."""
        return self["position"]

    @position.setter
    def position(self, value: npt.ArrayLike) -> None:
        self._assign("position", value)

    @property
    def velocity(self) -> Array:
        """Velocities of the grains, m/s, one row per grain. May be assigned."""
        return self["velocity"]

    @velocity.setter
    def velocity(self, value: npt.ArrayLike) -> None:
        self._assign("velocity", value)

    @property
    def spin(self) -> Array:
        """Spins of the grains, rad/s: one number in the plane, a vector in solid space. May be assigned."""
        return self["spin"]

    @spin.setter
    def spin(self, value: npt.ArrayLike) -> None:
        self._assign("spin", value)

    def _bytes(self, like: str, value: npt.ArrayLike) -> bytes:
        """Returns numbers for all grains, a row each; one row stands for all."""
        shape = self[like].shape
        try:
            return np.ascontiguousarray(np.broadcast_to(np.asarray(value, dtype="<f8"), shape)).tobytes()
        except ValueError as error:
            raise ValueError(f"{np.shape(value)} numbers do not fit {shape[0]} grains: {shape} are needed") from error

    def _assign(self, name: str, value: npt.ArrayLike) -> None:
        self._engine.assign(name, self._bytes(name, value))

    def add_force(self, force: npt.ArrayLike) -> None:
        """Pushes the grains with forces, N, a row for each or one for all, in every step of the next ``advance``; in a call of :meth:`every`, until the next call."""
        self._engine.push(self._bytes("position", force))

    def frame(self) -> pd.DataFrame:
        """Returns the grains as a pandas DataFrame."""
        return table(self.grains)

    # What else can be measured

    @property
    def totals(self) -> dict[str, float]:
        """Totals over the grains: energies (J), largest speed (m/s), largest overlap ratio, coordination number."""
        found: dict[str, float] = json.loads(self._engine.totals())
        return found

    @property
    def figures(self) -> dict[str, Any]:
        """The content of ``summary.json`` as it would be now."""
        found: dict[str, Any] = json.loads(self._engine.figures())
        return found

    @property
    def contacts(self) -> pd.DataFrame:
        """The contacts: ``grain``, ``partner`` and its ``partner_kind`` (0 grain, 1 wall grain, 2 wall surface by its number from 1), ``overlap`` (m), ``normal_force`` (N; above zero pushes), ``mobilised`` (friction over its cap), ``friction`` (N, on the grain), ``normal`` (towards the grain), ``centre`` (of the grain, m), ``branch`` (from there to the partner, m)."""
        return table(arrays(self._engine.contacts()))

    @property
    def walls(self) -> pd.DataFrame:
        """Force (N) and torque (N m) of the grains on each wall surface in the last step, in the order of the scene, with the name of the wall."""
        columns = self._engine.walls()
        names = columns.pop("name")
        found = table(arrays({name: column for name, column in columns.items() if not isinstance(column, list)}))
        found.insert(0, "name", pd.Series(list(names), dtype=object))
        return found

    def field(self, which: int = 0) -> pd.DataFrame:
        """Returns one sample of an entry of the scene's ``fields``: a row for each cell, with its place (m) and means such as ``density`` and ``v1``."""
        return table(arrays(self._engine.field(which)))

    # Files

    def state_hash(self) -> str:
        """Returns the hash of the grains' state: equal hashes are equal bits."""
        return self._engine.state_hash()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the whole state into a file, from which ``Simulation(scene, state=path)`` continues to the same bits. Pushes are not part of it."""
        self._engine.save(path)
