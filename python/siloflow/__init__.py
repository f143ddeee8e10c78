"""siloflow simulates grain in silos.

    import siloflow

    run = siloflow.run("scenes/silo1.ron", spawner__count=200, until=20.0)
    run.summary["discharge"]["rate_per_s"]   # grains per second
    run.series.plot("time_s", "out")         # a pandas DataFrame

    simulation = siloflow.Simulation("scenes/silo1.ron")
    simulation.advance_to(1.0)               # s
    simulation.position                      # a NumPy array, one row per grain, m

All numbers are SI.
"""

from siloflow._arrays import Frame
from siloflow._run import Run, RunFailed, run
from siloflow._siloflow import SceneError, __version__
from siloflow._simulation import Simulation

__all__ = ["Frame", "Run", "RunFailed", "SceneError", "Simulation", "__version__", "run"]
