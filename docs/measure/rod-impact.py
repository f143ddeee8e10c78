#!/usr/bin/env python3
"""Error of the impact of a rod at its end, over the step, for both schemes: the table of docs/explanation/shapes.md.

    python3 docs/measure/rod-impact.py --siloflow target/release/siloflow

A rod of four discs, 20 cm long, 6 cm wide and 10 kg, hits a floor at an angle of 0.6 rad with (0.3, -1) m/s, without gravity. The error is that of the
velocity and of 10 cm times the spin after the impact, against a step of 2e-6 s with the same scheme; root mean square over six steps that
differ by a few per cent, so that the contact begins at six places of a step. Takes about a minute.
"""

import argparse
import csv
import math
import pathlib
import subprocess
import tempfile

STEPS = (4e-4, 2e-4, 1e-4, 5e-5)
PHASES = (1, 1.013, 1.029, 1.041, 1.057, 1.071)
SCENE = """(
    gravity: (0.0, 0.0),
    contact: Linear(k: 1.0e4, damping: Restitution(0.6), tangential: Spring(k: 8.0e3, damping: B(2.0), friction: 0.4)),
    shapes: { "rod": Capsule(length: 0.2, diameter: 0.06, discs: 4) },
    integrator: %s, step: Fixed(%r), until: 0.5,
    grains: (file: "rod.csv"), walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))],
    pictures: None, checkpoint: None, watchdog: None, series: (interval: 1.0),
)"""
ROD = "id,shape,scale,mass,x,y,vx,vy,angle,wz\n1,rod,1,10.0,0.0,0.0803,0.3,-1.0,0.6,0.0\n"


def motion(siloflow, here, scheme, step):
    (here / "rod.ron").write_text(SCENE % (scheme, step))
    subprocess.run([siloflow, "run", "rod.ron", "--out", "out", "--force", "--quiet"], cwd=here, check=True)
    with open(here / "out" / "state.csv") as state:
        row = next(csv.DictReader(state))
    return float(row["vx"]), float(row["vy"]), 0.1 * float(row["wz"])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--siloflow", type=pathlib.Path, required=True)
    siloflow = parser.parse_args().siloflow.resolve()
    with tempfile.TemporaryDirectory() as directory:
        here = pathlib.Path(directory)
        (here / "rod.csv").write_text(ROD)
        print("step, s   " + " ".join(f"{step:8.0e}" for step in STEPS) + "  orders")
        for scheme in ("Verlet", "Centred"):
            exact = motion(siloflow, here, scheme, 2e-6)
            squares = [[math.dist(motion(siloflow, here, scheme, step * phase), exact) ** 2 for phase in PHASES] for step in STEPS]
            errors = [math.sqrt(sum(row) / len(row)) for row in squares]
            orders = [math.log2(coarse / fine) for coarse, fine in zip(errors, errors[1:])]
            print(f"{scheme:9s} " + " ".join(f"{error:8.1e}" for error in errors) + "  " + " ".join(f"{order:.2f}" for order in orders))


if __name__ == "__main__":
    main()
