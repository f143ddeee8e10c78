"""A silo in a notebook: run it, watch it, change it, plot it, and get a figure with its error.

Cells begin with ``# %%``: editors that know notebooks run them one by one, and ``python watch.py`` runs all of them.
"""

# %% A silo as a dictionary of scene keys. Text is RON; `variant` writes choices such as `HalfPlane(...)`.
import numpy as np

import siloflow
from siloflow import variant

SILO = {
    "title": "a small silo",
    "seed": 1,
    "gravity": (0.0, -9.81),  # m/s^2
    "mass": "Disc(100.0)",  # kg/m^2
    "step": variant("Auto", error=0.01),
    "contact": variant(
        "Linear", k=2e5, damping="Restitution(0.5)", tangential=variant("Spring", k=1e5, damping="OfNormal(1.0)", friction=0.4)
    ),
    "walls": [
        variant("Segment", **{"from": (-0.3, 0.5), "to": (-0.3, 2.5)}),
        variant("Segment", **{"from": (0.3, 0.5), "to": (0.3, 2.5)}),
        variant("Segment", **{"from": (-0.3, 0.5), "to": (-0.08, 0.0)}),
        variant("Segment", **{"from": (0.3, 0.5), "to": (0.08, 0.0)}),
        variant("Segment", **{"from": (-0.08, 0.0), "to": (0.08, 0.0), "door": True}),
    ],
    "fill": [{"low": (-0.28, 0.5), "high": (0.28, 1.6), "spacing": 0.034, "jitter": 0.002, "radius": "Uniform(0.013, 0.016)"}],
    "door": {"opens": "At(0.6)"},
    "cull": {"below": -0.5},
    "until": 6.0,  # s
    "pictures": None,
    "data_frames": {"interval": 0.02},
    "outflow": {"from": "Out(0.1)", "to": "Out(0.6)"},
}

# %% Run it, and look at the outcome. In a notebook, `run` is its report with the player.
run = siloflow.run(SILO, "out/watch", force=True, progress=True)
print(run.summary["status"], run.summary["discharge"])
run.plot("discharge")

# %% Step it, watch it, change it: a puff of air from below holds the grains back at the outlet.
simulation = siloflow.Simulation(SILO)
flow: list[tuple[float, int]] = []


def blow(now: siloflow.Simulation) -> None:
    """Pushes grains near the outlet upwards with twice their weight, from 1.5 s to 2 s."""
    flow.append((now.time, now.out))
    if 1.5 <= now.time < 2.0:
        x, y = now.position.T
        near = (np.abs(x) < 0.15) & (y < 0.25)
        now.add_force(np.outer(near * now.mass, [0.0, 2.0 * 9.81]))


simulation.every(20, blow)
simulation.advance_to(3.0, progress=True)
times, out = np.array(flow).T
for start in (1.0, 1.5, 2.0):
    during = (times >= start) & (times < start + 0.5)
    print(f"{start:.1f} s to {start + 0.5:.1f} s: {out[during].max() - out[during].min():.0f} grains")
print(f"the balance of energy is off by {simulation.figures['energy']['balance_error']:.2g} J")
simulation  # a picture of the grains

# %% What presses where.
print(simulation.walls)
print(simulation.contacts[["normal_force", "mobilised"]].describe())

# %% The discharge rate with its error: seeds and softer grains, until the mean over seeds is known within 5 %.
rate = siloflow.estimate(SILO, "outflow.rate_per_s.mean", within="5%", budget="3min", out="out/watch-rate")
print(rate)
