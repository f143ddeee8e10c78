#!/usr/bin/env python3
"""Time of a step of a sphere in a body of three spheres, beside that of a sphere by itself: the figures of docs/explanation/shapes.md.

    python3 docs/measure/clump-cost.py --siloflow target/release/siloflow
    python3 docs/measure/clump-cost.py --siloflow target/release/siloflow --bodies 3000 --lmp lmp      (LAMMPS too, with `fix rigid/small`)

Beds of bed3d's material, periodic sideways: 10,000 bodies of three spheres and 30,000 spheres, of the same spheres. Each is dropped and settles for 0.15 s. Then 400 steps
from its `state.csv` are timed, five times in alternation, on one core. LAMMPS makes the same steps from an export of the same scene; its time is that of its loop. Takes about
half an hour, with 3000 bodies some ten minutes.
"""

import argparse
import json
import pathlib
import re
import statistics
import subprocess
import tempfile

SCENE = """(
    seed: 1, space: Solid, gravity: (0.0, 0.0, -9.81), periodic: (x: (0.0, %(side)r), y: (0.0, %(side)r)),
    contact: Linear(k: 2568.2519, damping: PerMass(23420.86), attraction: Allowed,
        tangential: Spring(k: 733.7862, damping: PerMass(11710.43), friction: 0.5)),
    mass: Sphere(2500.0), integrator: Verlet, step: Fixed(2.5e-6),
    shapes: {%(shapes)s},
    walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))],
    %(grains)s, until: %(until)r, series: (interval: 1.0e-2), pictures: None, energy_balance: false, watchdog: None, checkpoint: None,
)"""
TRIPLE = """"tri": Spheres([(at: (0.0, 0.0, 0.0), radius: 0.5e-3), (at: (0.7e-3, 0.0, 0.0), radius: 0.5e-3),
        (at: (0.35e-3, 0.6e-3, 0.0), radius: 0.5e-3)])"""
FILL = """fill: [(low: (0.0, 0.0, 0.0), high: (%(side)r, %(side)r, 1.0), spacing: %(spacing)r, count: %(count)d, %(size)s,
        jitter: 3.5e-5, velocity: (0.0, 0.0, -0.025), agitation: (0.05, 0.05, 0.025))]"""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--siloflow", type=pathlib.Path, required=True)
    parser.add_argument("--bodies", type=int, default=10_000)
    parser.add_argument("--settle", type=float, default=0.15, help="s")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--lmp", help="LAMMPS")
    arguments = parser.parse_args()
    siloflow = arguments.siloflow.resolve()
    side = 0.027 * (arguments.bodies / 10_000) ** 0.5
    kinds = {
        "body": (TRIPLE, {"spacing": 1.5e-3, "count": arguments.bodies, "size": 'shape: "tri"'}, 3),
        "sphere": ("", {"spacing": 1.08e-3, "count": 3 * arguments.bodies, "size": "radius: Fixed(0.5e-3)"}, 1),
    }
    with tempfile.TemporaryDirectory() as directory:
        here = pathlib.Path(directory)

        def run(name, text):
            (here / f"{name}.ron").write_text(text)
            command = ["taskset", "-c", "1", siloflow, "run", f"{name}.ron", "--out", name, "--force", "--quiet", "--threads", "1"]
            subprocess.run(command, cwd=here, check=True)
            return json.loads((here / name / "summary.json").read_text())

        def lammps(name):
            """Loop time of LAMMPS, ns a step."""
            out = here / f"{name}-lammps"
            if not out.exists():
                export = [siloflow, "export", f"{name}-timed.ron", "--to", "lammps", "--out", out, "--quiet"]
                subprocess.run(export, cwd=here, check=True)
            command = ["taskset", "-c", "1", arguments.lmp, "-in", "in.silo", "-log", "none"]
            text = subprocess.run(command, cwd=out, check=True, capture_output=True, text=True).stdout
            loops = re.findall(r"Loop time of (\S+) on .* for (\d+) steps", text)
            return 1e9 * sum(float(loop) for loop, _ in loops) / sum(int(steps) for _, steps in loops)

        for name, (shapes, fill, _) in kinds.items():
            run(name, SCENE % {"side": side, "shapes": shapes, "grains": FILL % {"side": side, **fill}, "until": arguments.settle})
            (here / f"{name}.csv").write_text((here / name / "state.csv").read_text())
        times = {name: [] for name in kinds}
        theirs = {name: [] for name in kinds}
        for _ in range(arguments.rounds):
            for name, (shapes, _, spheres) in kinds.items():
                grains = f'grains: (file: "{name}.csv")'
                summary = run(f"{name}-timed", SCENE % {"side": side, "shapes": shapes, "grains": grains, "until": 1e-3})
                times[name].append(1e9 / summary["performance"]["particle_steps_per_s"] / spheres)
                contacts = summary["coordination"] / spheres
                print(f"{name:7s} {times[name][-1]:6.1f} ns a sphere and step, {contacts:.2f} contacts a sphere", flush=True)
                if arguments.lmp:
                    # Both beds have as many spheres.
                    theirs[name].append(lammps(name) / (3 * arguments.bodies))
                    print(f"        {theirs[name][-1]:6.1f} ns in LAMMPS", flush=True)
        for name, all_times in times.items():
            print(f"{name:7s} median {statistics.median(all_times):6.1f} ns, {min(all_times):.1f} to {max(all_times):.1f}")
            if arguments.lmp:
                middle = statistics.median(theirs[name])
                ratio = statistics.median(other / own for own, other in zip(all_times, theirs[name], strict=True))
                print(f"LAMMPS  median {middle:6.1f} ns, {min(theirs[name]):.1f} to {max(theirs[name]):.1f}, ratio {ratio:.2f}")


if __name__ == "__main__":
    main()
