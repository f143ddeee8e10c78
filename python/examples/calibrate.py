"""Finds the friction mu and the rolling resistance mu_r of a silo's grains from a measured discharge curve.

    python calibrate.py [measured.csv]

The file has the columns time_s (s since the outlet opened) and out_kg (mass that has left, kg; of a planar silo per metre of depth).
Without a file, the program first makes such a curve itself, with mu = 0.45 and mu_r = 0.15 and seeds that the calibration does not
use, so that the answer is known.

Method: the curve is the outflow at a few times. Runs at points of a Latin hypercube in (mu, mu_r), with several seeds, give the mean
curve at each point. A quadratic polynomial in the roots of mu and mu_r is fitted to each value of the curve, since discharge changes
fastest at low friction. The best (mu, mu_r) minimises the squared distance to the measured curve. Its weights are the inverse of a
covariance: the scatter of the seeds for the measured curve, and the residual of the fits for the polynomials.

A discharge curve constrains a combination of the two coefficients more than each of them: less friction with more rolling
resistance empties a silo as fast. The printed ranges contain this; the file misfit.csv has the whole map.
"""

import sys
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from pathlib import Path
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
import pandas as pd

import siloflow

Array: TypeAlias = npt.NDArray[np.float64]

SCENE = Path(__file__).parent / "silo.ron"
OUT = Path("out/calibration")
LOW, HIGH = np.array([0.1, 0.0]), np.array([0.8, 0.4])
POINTS, SEEDS = 40, (1, 2, 3, 4)
TRUTH, REPEATS = (0.45, 0.15), (101, 102, 103, 104, 105)


def discharge(mu: float, mu_r: float, seed: int) -> tuple[Array, Array]:
    """Runs the silo. Returns the times since the outlet opened (s) and the mass out (kg)."""
    name = OUT / f"{mu:.6f}-{mu_r:.6f}-{seed}"
    run = siloflow.run(SCENE, name, force=True, seed=seed, settings={"parameters.mu": mu, "parameters.mu_r": mu_r})
    series = run.series
    since = series["time_s"].to_numpy() - run.summary["door_open_time_s"]
    return since, series["out_kg"].to_numpy()


def curves_at(points: Array, seeds: tuple[int, ...], times: Array) -> Array:
    """Returns the curve of each seed at each point. Runs use all cores, one for each run."""
    with ThreadPoolExecutor(cpu_count()) as pool:
        runs = [[pool.submit(discharge, float(mu), float(mu_r), seed) for seed in seeds] for mu, mu_r in points]
        return np.array([[np.interp(times, *run.result()) for run in row] for row in runs])


def latin_hypercube(count: int) -> Array:
    random = np.random.default_rng(1)
    strata = np.array([random.permutation(count) for _ in LOW]).T
    return np.asarray(LOW + (HIGH - LOW) * (strata + random.random(strata.shape)) / count)


def terms(points: Array) -> Array:
    x, y = np.sqrt(np.atleast_2d(points)).T
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)


def measured() -> tuple[pd.DataFrame, int]:
    """Returns the measured curve, and the number of measurements of which it is the mean."""
    if len(sys.argv) > 1:
        return pd.read_csv(sys.argv[1]), 1
    print(f"no measured curve given: making one with mu = {TRUTH[0]} and mu_r = {TRUTH[1]}")
    times = np.linspace(0.0, 2.0, 41)
    [curves] = curves_at(np.array([TRUTH]), REPEATS, times)
    return pd.DataFrame({"time_s": times, "out_kg": curves.mean(axis=0)}), len(REPEATS)


def main() -> None:
    target, repeats = measured()
    # The part of the curve in which the silo flows.
    flows = target["out_kg"].between(0.05 * target["out_kg"].max(), 0.95 * target["out_kg"].max())
    times, curve = target["time_s"][flows].to_numpy(), target["out_kg"][flows].to_numpy()
    points = latin_hypercube(POINTS)
    curves = curves_at(points, SEEDS, times)
    means = curves.mean(axis=1)
    scatter = np.einsum("psi,psj->ij", curves - means[:, None], curves - means[:, None]) / (POINTS * (len(SEEDS) - 1))
    surface, *_ = np.linalg.lstsq(terms(points), means, rcond=None)
    residual = means - terms(points) @ surface
    covariance = scatter / repeats + residual.T @ residual / (POINTS - len(surface))
    # Neighbouring values are nearly equal, which makes the matrix nearly singular: a hundredth of its mean variance is added.
    covariance += 0.01 * np.trace(covariance) / len(times) * np.eye(len(times))
    mu, mu_r = (axis.ravel() for axis in np.meshgrid(*np.linspace(LOW, HIGH, 201).T, indexing="ij"))
    distance = terms(np.stack([mu, mu_r], axis=1)) @ surface - curve
    misfit = np.einsum("ij,jk,ik->i", distance, np.linalg.inv(covariance), distance)
    pd.DataFrame({"mu": mu, "mu_r": mu_r, "misfit": misfit}).to_csv(OUT / "misfit.csv", index=False)
    best, near = misfit.argmin(), misfit < misfit.min() + 1.0
    for name, axis in (("mu", mu), ("mu_r", mu_r)):
        print(f"{name:5} {axis[best]:.3f}, within one standard error from {axis[near].min():.3f} to {axis[near].max():.3f}")
    if len(sys.argv) == 1:
        truth = np.hypot(mu - TRUTH[0], mu_r - TRUTH[1]).argmin()
        print(f"misfit of the true coefficients: {misfit[truth] - misfit[best]:.1f} above the best; below 2.3 in 68 % of such trials")
    [found] = curves_at(np.array([[mu[best], mu_r[best]]]), SEEDS, times)
    print(f"rms distance of the curves: {np.sqrt(np.mean((found.mean(axis=0) - curve) ** 2)):.3f} kg of {curve.max():.1f} kg")


if __name__ == "__main__":
    main()
