"""siloflow simulates grain in silos.

    import siloflow

    run = siloflow.run("scenes/silo1.ron", spawner__count=200, until=20.0)
    run.summary["discharge"]["rate_per_s"]   # grains per second
    run.series.plot("time_s", "out")         # a pandas DataFrame
    run.plot("discharge")                    # a figure; run.show() is the report with the player

    simulation = siloflow.Simulation("scenes/silo1.ron")
    simulation.advance_to(1.0)               # s
    simulation.position                      # a NumPy array, one row per grain, m
    simulation.velocity = 0.0                # the state is assigned

    siloflow.estimate("scenes/silo1.ron", "discharge.rate_per_s", within="2%")

All numbers are SI.
"""

from siloflow._arrays import Frame
from siloflow._ron import variant
from siloflow._run import Figure, Page, Run, RunFailed, run
from siloflow._siloflow import SceneError, __version__
from siloflow._simulation import Simulation
from siloflow._studies import Estimate, estimate, sweep

__all__ = [
    "Estimate",
    "Figure",
    "Frame",
    "Page",
    "Run",
    "RunFailed",
    "SceneError",
    "Simulation",
    "__version__",
    "estimate",
    "run",
    "sweep",
    "variant",
]
