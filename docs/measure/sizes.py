#!/usr/bin/env python3
"""Time of the neighbour searches where sizes differ: one grid per size class, against one cell size.

    cargo build --release
    docs/measure/sizes.py [--siloflow target/release/siloflow] [--single PATH] [--rounds 3] [--steps 500]

A gas of spheres above a floor, in a box that is periodic along x and y: 16000 small spheres of R = 1 mm, and large ones of RATIO times
that with the same volume in all, at random places that fill 0.3 of the box, with velocities of up to 0.1 m/s. So the list is renewed often.

--single is a program whose list is always searched with one grid: this program, built with `WORTHWHILE` in
crates/dem/src/neighbours/verlet_list/size_classes.rs set to f64::INFINITY. Without it that row is left out.

The rows of a ratio alternate, pinned to one core. Prints the medians of ns per particle-step, and their ratio to the first row. Cells are
filled anew in every step, so that 20 steps of them tell their time. All runs of as many steps end in the same state, to the last bit, or
the script fails. No packages needed.
"""

import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SMALL, RADIUS, SHARE = 16000, 1.0e-3, 0.3  # grains, m
DT, FEW = 1.0e-5, 20  # s, steps


def scene(ratio):
    large = 0 if ratio == 1 else max(1, round(SMALL / ratio**3))
    width = max(0.06, 4.5 * ratio * RADIUS)
    volume = 4 / 3 * math.pi * RADIUS**3 * (SMALL + large * ratio**3)
    height = max(volume / SHARE / width**2, 2.2 * ratio * RADIUS)
    box = f"low: (0.0, 0.0, 0.0), high: ({width}, {width}, {height}), place: Random, agitation: (0.1, 0.1, 0.1)"
    fills = [f"({box}, count: {SMALL}, radius: Fixed({RADIUS}))"]
    if large:
        fills.insert(0, f"({box}, count: {large}, radius: Fixed({ratio * RADIUS}))")
    return f"""(space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e3, damping: Restitution(0.8)), mass: Sphere(2500.0),
    integrator: Verlet, step: Fixed({DT}), periodic: (x: (0.0, {width}), y: (0.0, {width})),
    walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))], fill: [{", ".join(fills)}],
    until: 1.0, pictures: None, series: (interval: 1.0))"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--siloflow", default=ROOT / "target/release/siloflow")
    parser.add_argument("--single")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--steps", type=int, default=500)
    parser.add_argument("--ratios", type=float, nargs="+", default=[1, 1.5, 2, 3, 5, 10, 20])
    parser.add_argument("--core", default="0")
    args = parser.parse_args()
    rows = [("list", args.siloflow, [], args.steps),
            ("cells of one size", args.siloflow, ["--set", "neighbours=CellsOfRange(rng: 2.0)"], FEW)]
    if args.single:
        rows.insert(1, ("list, one grid", args.single, [], args.steps))
    print(f"{'ratio':>5s}  {'search':20s} {'ns per particle-step':>20s} {'ratio':>7s} {'renewals':>9s}")
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "a.ron"
        for ratio in args.ratios:
            path.write_text(scene(ratio))
            times, renewals, states = {name: [] for name, *_ in rows}, {}, {}
            # Not timed: the state of the list after few steps.
            for timed, (name, program, settings, steps) in [(False, (*rows[0][:3], FEW))] + args.rounds * [(True, row) for row in rows]:
                command = ["taskset", "-c", args.core, program, "run", path, "--until", repr(steps * DT), *settings,
                           "--out", pathlib.Path(folder) / "out", "--force", "--quiet", "--json", "--threads", "1"]
                done = subprocess.run(command, check=False, capture_output=True, text=True)
                if done.returncode:
                    sys.exit(f"sizes.py: {done.stderr}")
                summary = json.loads(done.stdout)
                if states.setdefault(steps, summary["state_hash"]) != summary["state_hash"]:
                    sys.exit(f"sizes.py: states differ at ratio {ratio} after {steps} steps")
                if timed:
                    times[name].append(1e9 / summary["performance"]["particle_steps_per_s"])
                    renewals[name] = summary["performance"]["neighbour_rebuilds"]
            first = next(iter(times.values()))
            for name, own in times.items():
                slower = statistics.median(a / b for a, b in zip(own, first, strict=True))
                print(f"{ratio:5g}  {name:20s} {statistics.median(own):20.1f} {slower:7.2f} {renewals[name]:9d}", flush=True)


if __name__ == "__main__":
    main()
