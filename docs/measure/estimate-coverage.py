#!/usr/bin/env python3
"""How often the interval of `siloflow estimate` contains the truth, on small scenes with real chance and real softness.

    cargo build --release
    docs/measure/estimate-coverage.py [--repeats 200] [--first 0] [--siloflow PATH]       (about 40 minutes on two cores)

Each scene is estimated many times, each time with seeds of its own. The truth is the mean of many runs at the stiffness of the scene, with other seeds.
Prints the share of the intervals that contain it, the share that chance alone would give (95 %, with the standard error of so many repetitions), the mean
half width, the standard error of the truth, and the share of refusals.
"""

import argparse
import concurrent.futures
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
TROUGH = """(
    gravity: (0.0, -9.81),
    contact: Linear(k: 1.0e5, damping: Restitution(0.5), tangential: Spring(k: 2.9e4, damping: OfNormal(0.5), friction: 0.4)),
    mass: Disc(100.0), integrator: Verlet, step: Fixed(4.0e-5),
    walls: [
        HalfPlane(point: (-0.1, 0.0), normal: (1.0, 0.0)), HalfPlane(point: (0.1, 0.0), normal: (-1.0, 0.0)),
        Segment(from: (-0.1, 0.0), to: (-0.05, 0.0)), Segment(from: (0.05, 0.0), to: (0.1, 0.0)),
        Segment(from: (-0.05, 0.0), to: (0.05, 0.0), door: true),
    ],
    fill: [(low: (-0.09, 0.02), high: (0.09, 0.4), place: Random, count: 40, radius: Uniform(0.009, 0.011))],
    rest: (speed: 0.2, energy: 1.0e-3, hold: 0.02), door: (opens: AtRest), cull: (below: -0.2),
    stop: [EndOfFlow(still: 0.3)], until: 3.0, series: (interval: 0.01), pictures: None,
)"""
BOX = """(
    space: Solid, gravity: (0.0, 0.0, -9.81),
    contact: Hertz(restitution: 0.5, tangential: Mindlin(friction: 0.4)), materials: [(young: 1.0e7, poisson: 0.3)],
    mass: Sphere(2500.0), integrator: Verlet, step: Fixed(2.0e-5),
    walls: [
        HalfPlane(point: (-0.02, 0.0, 0.0), normal: (1.0, 0.0, 0.0)), HalfPlane(point: (0.02, 0.0, 0.0), normal: (-1.0, 0.0, 0.0)),
        HalfPlane(point: (0.0, -0.02, 0.0), normal: (0.0, 1.0, 0.0)), HalfPlane(point: (0.0, 0.02, 0.0), normal: (0.0, -1.0, 0.0)),
        HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0)),
    ],
    fill: [(low: (-0.017, -0.017, 0.003), high: (0.017, 0.017, 0.12), place: Random, count: 100, radius: Fixed(0.003))],
    until: 0.4, series: (interval: 0.01), pictures: None,
)"""
# Name, scene, figure, width, runs for the truth.
CASES = (
    ("discs, linear", TROUGH, "discharge.rate_per_s", "15%", 300),
    ("spheres, Hertz", BOX, "series.csv: potential, 0.35 s to 0.4 s", "1%", 200),
    ("lattice gas", None, "series.csv: at_rest, 200 to 300", "0.2%", 150),
)


def call(siloflow, scene, figure, within, seed, folder, more):
    words = [siloflow, "estimate", scene, "--figure", figure, "--within", within, "--seed", str(seed), "--cores", "1", "--json", "--quiet", "--out", folder, *more]
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True)
    if not done.stdout:
        sys.exit(done.stderr)
    return json.loads(done.stdout)


def truth(siloflow, scene, figure, runs, folder, more):
    """Mean of runs at the stiffness of the scene, and its standard error."""
    values = []
    lists = [["--seed", str(1_000_000 + n)] for n in range(runs)]
    run = lambda n: call_run(siloflow, scene, lists[n], folder / f"truth-{n}", more)
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        list(pool.map(run, range(runs)))
    for n in range(runs):
        value = figure_of(folder / f"truth-{n}", figure)
        if value is not None:
            values.append(value)
    return statistics.fmean(values), statistics.stdev(values) / len(values) ** 0.5


def call_run(siloflow, scene, seed, folder, more):
    words = [siloflow, "--quiet", "run", scene, *seed, "--set", "pictures=None", "--threads", "1", "--out", folder, *more]
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{words} failed:\n{done.stderr}")


def figure_of(folder, figure):
    """The same figures, read without siloflow."""
    if not figure.startswith("series.csv"):
        value = json.loads((folder / "summary.json").read_text())
        for key in figure.split("."):
            value = value and value.get(key)
        return value
    column, window = (part.strip() for part in figure.split(":")[1].split(","))
    low, high = (float(word.split()[0]) for word in window.split(" to "))
    lines = [line.split(",") for line in (folder / "series.csv").read_text().splitlines() if line[0] != "#"]
    names = lines[0]
    at = names.index("time_s" if "time_s" in names else "step")
    of = next(n for n, name in enumerate(names) if name in (column, column + "_j"))
    inside = [float(line[of]) for line in lines[1:] if low - 1e-9 <= float(line[at]) <= high + 1e-9]
    return statistics.fmean(inside)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="number of the first repetition, which decides the seeds")
    parser.add_argument("--only", nargs="*", help="names of scenes, or parts of them")
    parser.add_argument("--siloflow", type=pathlib.Path, default=ROOT / "target/release/siloflow")
    args = parser.parse_args()
    print("| scene | figure | asked for | repetitions | intervals with the truth | mean half width | error of the truth | refused |\n|---|---|---|---|---|---|---|---|")
    for name, text, figure, within, runs in CASES:
        if args.only and not any(part in name for part in args.only):
            continue
        with tempfile.TemporaryDirectory() as here:
            here = pathlib.Path(here)
            scene = here / "scene.ron"
            more = []
            if text:
                scene.write_text(text)
            else:
                scene, more = ROOT / "scenes/silo2d-lattice.ron", ["--set", "until=300"]
            exact, error = truth(args.siloflow, scene, figure, runs, here, more)
            estimate = lambda n: call(args.siloflow, scene, figure, within, 1000 * n + 1, here / f"estimate-{n}", more)
            with concurrent.futures.ThreadPoolExecutor(2) as pool:
                found = list(pool.map(estimate, range(args.first, args.first + args.repeats)))
            given = [it for it in found if it["refused"] is None]
            hits = sum(it["interval"][0] <= exact <= it["interval"][1] for it in given)
            half = statistics.fmean(0.5 * (it["interval"][1] - it["interval"][0]) for it in given)
            share = hits / len(given)
            print(f"| {name} | `{figure}` | {within} | {len(found)} | {share:.3f} ± {(share * (1 - share) / len(given)) ** 0.5:.3f} | {half:.3g} | {error:.2g} | {len(found) - len(given)} |", flush=True)


if __name__ == "__main__":
    main()
