#!/usr/bin/env python3
"""Time of a step of a sphere in a body of three spheres, beside that of a sphere by itself: the figures of docs/explanation/shapes.md.

    python3 docs/measure/clump-cost.py --siloflow target/release/siloflow
    python3 docs/measure/clump-cost.py --siloflow target/release/siloflow --bodies 3000 --lmp lmp      (LAMMPS too, with `fix rigid/small`)

Beds of bed3d's material, periodic sideways: 10,000 bodies of three spheres and 30,000 spheres, of the same spheres. Each is dropped without overlaps and settles for 0.3 s;
the script stops if a grain still moves faster than 0.1 m/s. Then 400 steps from its `state.csv` are timed, five times in alternation, on one core. A third bed has the spheres at
rest, apart from each other and without gravity: no contacts. Between the two beds of spheres the time at the contacts of a body's sphere is interpolated. LAMMPS makes the same
steps from an export of the same scene; its time is that of its loop. Takes about 12 minutes, with 3000 bodies 4.
"""

import argparse
import csv
import json
import pathlib
import re
import statistics
import subprocess
import tempfile

SCENE = """(
    seed: 1, space: Solid, gravity: (0.0, 0.0, %(gravity)r), periodic: (x: (0.0, %(side)r), y: (0.0, %(side)r)),
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
STILL = """fill: [(low: (0.0, 0.0, 0.0), high: (%(side)r, %(side)r, 1.0), spacing: %(spacing)r, count: %(count)d, %(size)s)]"""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--siloflow", type=pathlib.Path, required=True)
    parser.add_argument("--bodies", type=int, default=10_000)
    parser.add_argument("--settle", type=float, default=0.3, help="s")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--lmp", help="LAMMPS")
    arguments = parser.parse_args()
    siloflow = arguments.siloflow.resolve()
    side = 0.027 * (arguments.bodies / 10_000) ** 0.5
    spheres_alone = {"spacing": 1.08e-3, "count": 3 * arguments.bodies, "size": "radius: Fixed(0.5e-3)"}
    kinds = {
        # Bodies in any orientation do not overlap: their farthest points are 0.90 mm from the centre.
        "body": (TRIPLE, {"spacing": 1.9e-3, "count": arguments.bodies, "size": 'shape: "tri"'}, 3, -9.81),
        "sphere": ("", spheres_alone, 1, -9.81),
        "apart": ("", spheres_alone, 1, 0.0),
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

        for name, (shapes, fill, _, gravity) in kinds.items():
            numbers = {"side": side, "shapes": shapes, "gravity": gravity}
            grains = FILL if gravity else STILL
            until = arguments.settle if gravity else 1e-5
            run(name, SCENE % {**numbers, "grains": grains % {"side": side, **fill}, "until": until})
            with (here / name / "series.csv").open() as series:
                speed = float(list(csv.DictReader(series))[-1]["largest_speed_m_per_s"])
            if speed > 0.1:
                raise SystemExit(f"{name}: a grain moves with {speed} m/s after {until} s; give a longer --settle")
            (here / f"{name}.csv").write_text((here / name / "state.csv").read_text())
        times = {name: [] for name in kinds}
        theirs = {name: [] for name in kinds}
        contacts = {}
        for _ in range(arguments.rounds):
            for name, (shapes, _, spheres, gravity) in kinds.items():
                numbers = {"side": side, "shapes": shapes, "gravity": gravity, "grains": f'grains: (file: "{name}.csv")'}
                summary = run(f"{name}-timed", SCENE % {**numbers, "until": 1e-3})
                times[name].append(1e9 / summary["performance"]["particle_steps_per_s"] / spheres)
                contacts[name] = summary["coordination"] / spheres
                print(f"{name:7s} {times[name][-1]:6.1f} ns a sphere and step, {contacts[name]:.2f} contacts a sphere", flush=True)
                if arguments.lmp and gravity:
                    # Both beds have as many spheres.
                    theirs[name].append(lammps(name) / (3 * arguments.bodies))
                    print(f"        {theirs[name][-1]:6.1f} ns in LAMMPS", flush=True)
        for name, all_times in times.items():
            print(f"{name:7s} median {statistics.median(all_times):6.1f} ns, {min(all_times):.1f} to {max(all_times):.1f}")
            if theirs[name]:
                middle = statistics.median(theirs[name])
                ratio = statistics.median(other / own for own, other in zip(all_times, theirs[name], strict=True))
                print(f"LAMMPS  median {middle:6.1f} ns, {min(theirs[name]):.1f} to {max(theirs[name]):.1f}, ratio {ratio:.2f}")
        body, sphere, apart = (statistics.median(times[name]) for name in kinds)
        equal = apart + (sphere - apart) * contacts["body"] / contacts["sphere"]
        print(f"a sphere alone with {contacts['body']:.2f} contacts: {equal:.1f} ns; one of a body takes {body / equal:.2f} times as long")


if __name__ == "__main__":
    main()
