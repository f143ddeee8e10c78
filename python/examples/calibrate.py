"""Finds the friction mu and the rolling resistance mu_r of a silo's grains from a measured discharge curve.

    python calibrate.py [measured.csv]

The file has the columns time_s (s since the outlet opened) and out_kg (mass that has left, kg; of a planar silo per metre of depth).
Without a file, the program first makes such a curve itself, with mu = 0.45 and mu_r = 0.15 and seeds that the calibration does not
use, so that the answer is known.

Method: the curve is the outflow at a few times. Runs at points of a Latin hypercube in (mu, mu_r), with several seeds, give the mean
curve at each point. A quadratic polynomial in (mu, mu_r) is fitted to each value of the curve, with mu and mu_r on a scale of roots,
since discharge changes fastest at low friction. The best (mu, mu_r) minimises the squared distance to the measured curve in units
of the residual of these fits. Standard errors come from the curvature at the minimum.
"""

import sys
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from pathlib import Path

import numpy as np
import pandas as pd

import siloflow

SCENE = Path(__file__).parent / "silo.ron"
OUT = Path("out/calibration")
LOW, HIGH = np.array([0.1, 0.0]), np.array([0.8, 0.4])
POINTS, SEEDS = 24, (1, 2, 3)
TRUTH = (0.45, 0.15)


def discharge(mu: float, mu_r: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Runs the silo. Returns the times since the outlet opened (s) and the mass out (kg)."""
    name = OUT / f"{mu:.6f}-{mu_r:.6f}-{seed}"
    run = siloflow.run(SCENE, name, force=True, seed=seed, settings={"parameters.mu": mu, "parameters.mu_r": mu_r})
    series = run.series
    since = series["time_s"].to_numpy() - run.summary["door_open_time_s"]
    return since, series["out_kg"].to_numpy()


def mean_curves(points: np.ndarray, seeds: tuple[int, ...], times: np.ndarray) -> np.ndarray:
    """Returns the mean curve over the seeds at each point. Runs use all cores, one for each run."""
    with ThreadPoolExecutor(cpu_count()) as pool:
        runs = {(k, seed): pool.submit(discharge, *point, seed) for k, point in enumerate(points) for seed in seeds}
        curves = {key: np.interp(times, *run.result()) for key, run in runs.items()}
    return np.array([np.mean([curves[k, seed] for seed in seeds], axis=0) for k in range(len(points))])


def latin_hypercube(count: int) -> np.ndarray:
    random = np.random.default_rng(1)
    strata = np.array([random.permutation(count) for _ in LOW]).T
    return LOW + (HIGH - LOW) * (strata + random.random(strata.shape)) / count


def terms(points: np.ndarray) -> np.ndarray:
    x, y = np.sqrt(np.atleast_2d(points)).T
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)


def measured() -> pd.DataFrame:
    if len(sys.argv) > 1:
        return pd.read_csv(sys.argv[1])
    print(f"no measured curve given: making one with mu = {TRUTH[0]} and mu_r = {TRUTH[1]}")
    times = np.linspace(0.0, 2.0, 41)
    [curve] = mean_curves(np.array([TRUTH]), (101, 102, 103, 104, 105), times)
    return pd.DataFrame({"time_s": times, "out_kg": curve})


def main() -> None:
    target = measured()
    # The part of the curve in which the silo flows: from 10 to 80 % out.
    flows = target["out_kg"].between(0.1 * target["out_kg"].max(), 0.8 * target["out_kg"].max())
    times, curve = target["time_s"][flows].to_numpy(), target["out_kg"][flows].to_numpy()
    points = latin_hypercube(POINTS)
    curves = mean_curves(points, SEEDS, times)
    surface, *_ = np.linalg.lstsq(terms(points), curves, rcond=None)
    residual = curves - terms(points) @ surface
    freedom = POINTS - surface.shape[0]
    # Values of one curve vary together, so their distance is that of the whole covariance, with a small share of its mean variance added.
    covariance = residual.T @ residual / freedom
    covariance += 0.01 * np.trace(covariance) / len(times) * np.eye(len(times))
    inverse = np.linalg.inv(covariance)
    grid = np.stack(np.meshgrid(*(np.linspace(low, high, 401) for low, high in zip(LOW, HIGH)), indexing="ij"), axis=-1)
    distance = terms(grid.reshape(-1, 2)) @ surface - curve
    misfit = np.einsum("ij,jk,ik->i", distance, inverse, distance)
    best = grid.reshape(-1, 2)[misfit.argmin()]
    near = misfit - misfit.min() < 1.0
    spread = grid.reshape(-1, 2)[near]
    pd.DataFrame({"mu": points[:, 0], "mu_r": points[:, 1]}).join(pd.DataFrame(curves, columns=[f"{t:.3f}" for t in times])) \
        .to_csv(OUT / "curves.csv", index=False)
    for name, value, low, high in zip(("mu", "mu_r"), best, spread.min(axis=0), spread.max(axis=0)):
        print(f"{name:5} {value:.3f}, between {low:.3f} and {high:.3f} within one standard error")
    [found] = mean_curves(np.array([best]), SEEDS, times)
    print(f"rms distance of the curves: {np.sqrt(np.mean((found - curve) ** 2)):.3f} kg of {curve.max():.1f} kg")


if __name__ == "__main__":
    main()
