#!/usr/bin/env python3
"""Cost of a mesh in place of cylinder and cone: the silo of a published benchmark, emptied through its large orifice.

    cargo build --release
    docs/measure/benchmark-silo.py [--siloflow target/release/siloflow] [--grains 100000] [--rounds 3] [--keep FOLDER]

The silo and its material M1 are those of Dosta et al. 2024, Comput. Phys. Commun. 296, 109066: spheres of 4 mm in a cylinder of radius
100 mm above a cone of 45 degrees with an orifice of 60 mm, e = 0.5 and mu = 0.3 (0.4 and 0.2 at the wall), Hertz and Mindlin. The walls
are a cylinder and a cone, or a mesh of 7680 triangles (120 around, 8 rings of the cone, 24 of the cylinder). The cylinder is higher than
published, so that the grains can be placed in it.

The bed comes to rest once, between cylinder and cone, with Young's modulus 1e7 Pa. Both walls then start from it (`--from`):

* soft: the first 0.1 s after the opening with 1e7 Pa and steps of 1.5e-5 s;
* stiff: the first 0.01 s with the published 1e9 Pa and 1.5e-6 s, after 4.5 ms in which strong damping takes the energy of the overlaps
  that belong to 1e7 Pa.

Runs of the two walls alternate, pinned to one core. Prints the times of all runs and the median ratio. No packages needed.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

from round_mesh import obj_text

ROOT = pathlib.Path(__file__).resolve().parents[2]
ORIFICE, RADIUS = 0.03, 0.1  # m
LOW, CONE, TOP = -0.0554222, 0.0145778, 0.45  # m
AROUND = 120
SPACING = 4.15e-3  # m
ANALYTIC = f"""Cylinder(from: (0.0, 0.0, {CONE}), to: (0.0, 0.0, {TOP}), radius: {RADIUS}, species: 1),
        Cone(from: (0.0, 0.0, {LOW}), to: (0.0, 0.0, {CONE}), radii: ({ORIFICE}, {RADIUS}), species: 1),"""
MESH = 'Mesh(file: "silo.obj", unit: Metre, species: 1),'


def mesh():
    """The OBJ text of cone and cylinder."""
    line = [(ORIFICE + (RADIUS - ORIFICE) * i / 8, LOW + (CONE - LOW) * i / 8) for i in range(9)]
    line += [(RADIUS, CONE + (TOP - CONE) * i / 24) for i in range(1, 25)]
    return obj_text(line, AROUND)


def scene(walls, grains, young, dt, e=(0.5, 0.4)):
    law = "Hertz(restitution: {}, tangential: Mindlin(friction: {}))"
    return f"""(space: Solid, seed: 1, gravity: (0.0, 0.0, -9.81), mass: Sphere(2500.0), integrator: Verlet, step: Fixed({dt}),
    contact: {law.format(e[0], 0.3)}, pairs: [(species: (0, 1), contact: {law.format(e[1], 0.2)})],
    materials: [(young: {young}, poisson: 0.2), (young: {210 * young}, poisson: 0.2)],
    walls: [{walls}
        Annulus(centre: (0.0, 0.0, {LOW}), normal: (0.0, 0.0, 1.0), outer: {ORIFICE}, species: 1, door: true)],
    fill: [(low: (-0.0695, -0.0695, {CONE}), high: (0.0695, 0.0695, {TOP}), spacing: {SPACING}, count: {grains}, radius: Fixed(2.0e-3),
        jitter: 7.0e-5)],
    door: (opens: Never), cull: (below: {LOW - 0.02}), until: 1.0, pictures: None, series: (interval: 0.1))"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--siloflow", type=pathlib.Path, default=ROOT / "target/release/siloflow")
    parser.add_argument("--grains", type=int, default=100000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--cases", nargs="+", default=["soft", "stiff"])
    parser.add_argument("--settle", default="0.4", help="s")
    parser.add_argument("--threads", default="2", help="of the runs that are not timed")
    parser.add_argument("--core", default="0")
    parser.add_argument("--keep", type=pathlib.Path, help="keeps the runs here, and uses those that are here")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = (args.keep or pathlib.Path(scratch)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "silo.obj").write_text(mesh())

        def run(name, out, until, *more, before=(), threads="1", settings=()):
            command = [*before, args.siloflow.resolve(), "run", name, "--out", out, "--until", until, "--force", "--quiet", "--json",
                       "--threads", threads, *more, *(word for setting in settings for word in ("--set", setting))]
            done = subprocess.run([str(word) for word in command], cwd=folder, check=False, capture_output=True, text=True)
            if done.returncode:
                sys.exit(f"benchmark-silo.py: exit status {done.returncode}\n{done.stdout[-500:]}{done.stderr[-1500:]}")
            return json.loads(done.stdout)

        def write(name, *rest, **more):
            (folder / name).write_text(scene(*rest, **more))

        for kind, walls in (("analytic", ANALYTIC), ("mesh", MESH)):
            write(f"{kind}-soft.ron", walls, args.grains, 1e7, 1.5e-5)
            write(f"{kind}-stiff.ron", walls, args.grains, 1e9, 1.5e-6)
        write("damped.ron", ANALYTIC, args.grains, 1e9, 1.5e-6, e=(0.05, 0.05))
        if not (folder / "bed-soft").exists():
            run("analytic-soft.ron", "bed-soft", args.settle, threads=args.threads)
        if "stiff" in args.cases and not (folder / "bed-stiff").exists():
            run("damped.ron", "bed-stiff", "4.5e-3", "--from", "bed-soft", threads=args.threads)
        for case in args.cases:
            until = {"soft": "0.1", "stiff": "0.01"}[case]
            times = {"analytic": [], "mesh": []}
            for _ in range(args.rounds):
                for kind, own in times.items():
                    found = run(f"{kind}-{case}.ron", "timed", until, "--from", f"bed-{case}", before=("taskset", "-c", args.core),
                                settings=("door.opens=At(0.0)",))
                    own.append(found["performance"]["wall_s"])
                    print(f"{case} {kind:9s} {own[-1]:8.2f} s, {1e9 / found['performance']['particle_steps_per_s']:6.1f} ns per particle-step, "
                          f"{found['grains']['out']} out, {found['performance']['neighbour_rebuilds']} renewals", flush=True)
            ratio = statistics.median(m / a for m, a in zip(times["mesh"], times["analytic"], strict=True))
            print(f"{case} mesh over analytic: {ratio:.3f}", flush=True)


if __name__ == "__main__":
    main()
