#!/usr/bin/env python3
"""The impact of Dosta et al. 2024 in siloflow and in LAMMPS from the same bed, and in siloflow from a denser bed.

    python3 docs/measure/impact-lammps.py --siloflow target/release/siloflow [--friction 0.0 --settle 0.16] [--skip-lammps] [--grains 25000]

Needs the standard library and LAMMPS as `lmp` (Debian: lammps). The bed is that of scenes/validation/dosta-impact/impact.ron after `--settle`, without the ball. `--friction`
is the friction between grains while the bed settles: 0 gives a dense bed. Then the ball enters 20 ms after the published start, with the place and velocity of its free
flight, and both programs run 15 ms. Prints the packing fraction of the bed's core, and for each program the deepest point and its time after the published start. An hour
on one core, of which siloflow takes a sixth.
"""

import argparse
import csv
import math
import pathlib
import re
import subprocess
import sys

SCENE = pathlib.Path(__file__).resolve().parents[2] / "scenes/validation/dosta-impact/impact.ron"
BALL, START, FLOOR = 0.01, 0.02, -0.090243  # m: radius; s: after the published start; m


def call(command, folder, **more):
    done = subprocess.run(list(map(str, command)), cwd=folder, capture_output=True, text=True, **more)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))} failed:\n{done.stdout[-1000:]}{done.stderr[-2000:]}")


def scenes(options):
    """The scene that makes the bed, and the scene of the impact."""
    text = SCENE.read_text().replace("count: 25000", f"count: {options.grains}")
    ball = text[text.index("        (low: (-0.01, -0.01, \"= height"):text.index("    ],\n    until")]
    bed = re.sub(r"(\n    contact: Hertz\(restitution: 0.5, tangential: Mindlin\(friction: )0.3", rf"\g<1>{options.friction}", text)
    bed = bed.replace('"start": 0.1,', f'"start": {options.settle},').replace(ball, "").replace('until: "= start + 0.035"', 'until: "= start + 0 * speed * height"')
    height, speed = 0.06 - 5 * START - 9.81 * START**2 / 2, 5 + 9.81 * START
    hit = text[:text.index("    fill: [")] + f"""    grains: (file: "bed.csv"),
    fill: [(low: (-0.01, -0.01, {height - BALL}), high: (0.01, 0.01, {height + BALL}), spacing: 0.02, count: 1,
            radius: Fixed({BALL}), velocity: (0.0, 0.0, {-speed}), species: 1, mass: Sphere(7200.0))],
""" + text[text.index("    until"):].replace('"= start + 0.035"', '"= 0.015 + 0 * start * speed * height"')
    return bed, hit


def packing(path):
    """Solid fraction from 8 to 18 mm above the floor, away from the walls."""
    with open(path, newline="") as file:
        centres = [tuple(float(row[axis]) for axis in "xyz") for row in csv.DictReader(file)]
    core = [1 for x, y, z in centres if abs(x) < 0.04 and abs(y) < 0.02 and 0.008 < z - FLOOR < 0.018]
    return len(core) * 4 / 3 * math.pi * 1e-9 / (0.08 * 0.04 * 0.01)


def ours(options, folder):
    call([options.siloflow, "run", "hit.ron", "--out", "hit", "--force", "--quiet"], folder)
    with open(folder / "hit/centres.csv", newline="") as file:
        return [(float(row["time_s"]), float(row["z_m"])) for row in csv.DictReader(file) if row["species"] == "1"]


def theirs(options, folder):
    call(["rm", "-rf", "lammps"], folder)
    call([options.siloflow, "export", "hit.ron", "--to", "lammps", "--out", "lammps", "--quiet"], folder)
    script = folder / "lammps/in.silo"
    path = 'group ball type 2\ncompute ball_z ball reduce max z\nvariable ball_z equal c_ball_z\n' \
        'fix ball all print 133 "$(time:%.9f) $(v_ball_z:%.9g)" file ball.txt screen no\n'
    text = script.read_text()
    at = text.index("fix series all print")
    script.write_text(text[:at] + path + text[at:])
    call([options.lmp, "-in", "in.silo", "-screen", "none"], folder / "lammps")
    with open(folder / "lammps/ball.txt") as file:
        return [tuple(map(float, line.split())) for line in file if line[0] != "#"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--siloflow", type=pathlib.Path, default=pathlib.Path("target/release/siloflow"))
    parser.add_argument("--lmp", default="lmp")
    parser.add_argument("--dir", type=pathlib.Path, default=pathlib.Path("target/impact"), help="for the runs")
    parser.add_argument("--friction", type=float, default=0.3, help="between grains while the bed settles")
    parser.add_argument("--settle", type=float, default=0.1, help="time for which the bed settles, s")
    parser.add_argument("--grains", type=int, default=25000)
    parser.add_argument("--skip-lammps", action="store_true")
    options = parser.parse_args()
    options.siloflow = options.siloflow.resolve()
    options.dir.mkdir(parents=True, exist_ok=True)
    bed, hit = scenes(options)
    (options.dir / "bed.ron").write_text(bed)
    (options.dir / "hit.ron").write_text(hit)
    call([options.siloflow, "run", "bed.ron", "--out", "bed", "--force", "--quiet"], options.dir)
    (options.dir / "bed.csv").write_text((options.dir / "bed/state.csv").read_text())
    print(f"packing fraction {packing(options.dir / 'bed.csv'):.3f}")
    for name, run in (("siloflow", ours), ("LAMMPS", theirs)):
        if name == "siloflow" or not options.skip_lammps:
            time, height = min(run(options, options.dir), key=lambda point: point[1])
            print(f"{name}: deepest {1e3 * height:.2f} mm at {1e3 * (START + time):.2f} ms", flush=True)


if __name__ == "__main__":
    main()
