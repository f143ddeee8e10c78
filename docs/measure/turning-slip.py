#!/usr/bin/env python3
"""Error of friction whose direction turns, in space, over the step, for both schemes: docs/explanation/shapes.md and accuracy.md.

    python3 docs/measure/turning-slip.py --siloflow target/release/siloflow

Two motions:

* Impacts: a jack of seven spheres, 15 cm long and 0.25 kg, spins and hits a floor with one of its arms at 1 m/s, without gravity. Nine impacts, and
  four phases of the step for each. The error is that of the velocity, and of 4 cm times the spin.
* Groove: a sphere of 5 cm and 1 kg slides along a groove of two walls at right angles, and spins about the groove and the vertical. Both contacts
  slip all the time, and their forces turn. The error is that of the velocity, and of 5 cm times the spin, after 0.1 s.

Errors are against a step of a sixty-fourth of the finest with the same scheme; root mean squares. Takes about a minute.
"""

import argparse
import csv
import math
import pathlib
import random
import subprocess
import tempfile

COUNTS = (200, 400, 800, 1600)
CONTACT = "Linear(k: 1.0e5, damping: Restitution(0.5), tangential: Spring(k: 2.86e4, damping: OfNormal(0.5), friction: 0.3))"
KEYS = f"""space: Solid, contact: {CONTACT}, grains: (file: "grains.csv"),
    pictures: None, checkpoint: None, watchdog: None, rest: None, series: (interval: 1.0),"""
IMPACT = f"""(
    {KEYS} gravity: (0.0, 0.0, 0.0), until: 0.04, integrator: %s, step: Fixed(%r),
    shapes: {{ "jack": Spheres([
        (at: (0.0, 0.0, 0.0), radius: 0.03), (at: (0.05, 0.0, 0.0), radius: 0.025), (at: (-0.05, 0.0, 0.0), radius: 0.025),
        (at: (0.0, 0.05, 0.0), radius: 0.023), (at: (0.0, -0.05, 0.0), radius: 0.023),
        (at: (0.0, 0.0, 0.05), radius: 0.021), (at: (0.0, 0.0, -0.05), radius: 0.021),
    ]) }},
    walls: [HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))],
)"""
GROOVE = f"""(
    {KEYS} gravity: (0.0, 0.0, -9.81), until: 0.1, integrator: %s, step: Fixed(%r),
    walls: [HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.0, 1.0, 1.0)), HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.0, -1.0, 1.0))],
)"""


def motion(siloflow, here, scene, grains, scheme, step, reach):
    (here / "scene.ron").write_text(scene % (scheme, step))
    (here / "grains.csv").write_text(grains)
    subprocess.run([siloflow, "run", "scene.ron", "--out", "out", "--force", "--quiet"], cwd=here, check=True)
    with open(here / "out" / "state.csv") as state:
        row = next(csv.DictReader(state))
    return [float(row[key]) for key in ("vx", "vy", "vz")] + [reach * float(row[key]) for key in ("wx", "wy", "wz")]


def times(p, q):
    (w, x, y, z), (a, b, c, d) = p, q
    return (w * a - x * b - y * c - z * d, w * b + x * a + y * d - z * c, w * c - x * d + y * a + z * b, w * d + x * c - y * b + z * a)


def impact(number, phase):
    """A jack with an arm along x, y or -z downwards, tilted by up to 0.4 rad."""
    half = math.sqrt(0.5)
    downwards = [(half, 0.0, half, 0.0), (half, -half, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)][number % 3]
    draw = random.Random(number)
    tilt = [draw.uniform(-0.15, 0.15) for _ in range(2)]
    lean = (math.sqrt(1.0 - tilt[0] ** 2 - tilt[1] ** 2), *tilt, 0.0)
    velocity = [draw.uniform(-0.6, 0.6), draw.uniform(-0.6, 0.6), -1.0]
    spin = [draw.uniform(-15.0, 15.0) for _ in range(3)]
    numbers = [1, 0.25, 0.0, 0.0, 0.085 + 2e-5 * phase, *velocity, *spin, "jack", 1, *times(lean, downwards)]
    return "id,mass,x,y,z,vx,vy,vz,wx,wy,wz,shape,scale,qw,qx,qy,qz\n" + ",".join(map(str, numbers)) + "\n"


def groove():
    radius, mass = 0.05, 1.0
    z = math.sqrt(2.0) * (radius - 9.81 * mass / (math.sqrt(2.0) * 1e5))
    return f"id,radius,mass,x,y,z,vx,vy,vz,wx,wy,wz\n1,{radius},{mass},0,0,{z},0.5,0,0,12,0,5\n"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--siloflow", type=pathlib.Path, required=True)
    siloflow = parser.parse_args().siloflow.resolve()
    impacts = [impact(number, phase) for number in range(9) for phase in range(4)]
    with tempfile.TemporaryDirectory() as directory:
        here = pathlib.Path(directory)
        for name, scene, until, reach, cases in (("impacts", IMPACT, 0.04, 0.04, impacts), ("groove", GROOVE, 0.1, 0.05, [groove()])):
            print(f"{name}: step, s    " + " ".join(f"{until / count:8.1e}" for count in COUNTS) + "  orders")
            for scheme in ("Verlet", "Centred"):
                squares = [[] for _ in COUNTS]
                for grains in cases:
                    exact = motion(siloflow, here, scene, grains, scheme, until / (64 * COUNTS[-1]), reach)
                    for row, count in zip(squares, COUNTS):
                        row.append(math.dist(motion(siloflow, here, scene, grains, scheme, until / count, reach), exact) ** 2)
                errors = [math.sqrt(sum(row) / len(row)) for row in squares]
                orders = [math.log2(coarse / fine) for coarse, fine in zip(errors, errors[1:])]
                print(f"{scheme:18s} " + " ".join(f"{error:8.1e}" for error in errors) + "  " + " ".join(f"{order:.2f}" for order in orders), flush=True)


if __name__ == "__main__":
    main()
