#!/usr/bin/env python3
"""Cost of the walls of scenes/round-silo.ron: as cylinder and cone, as half-spaces and panels, and as a mesh.

    cargo build --release
    docs/measure/round-walls.py [--siloflow target/release/siloflow] [--rounds 5] [--until 0.6]

The mesh has 8192 triangles: 128 around, 32 rings. The flat walls are 24 half-spaces and 24 panels, tangent to the cylinder and the
cone. All three runs alternate, pinned to one core. Prints the median of ns per particle-step, and the median ratio to the first.
No packages needed.
"""

import argparse
import json
import math
import pathlib
import statistics
import subprocess
import tempfile

from round_mesh import obj_text

ROOT = pathlib.Path(__file__).resolve().parents[2]
AROUND, SIDES = 128, 24
OUTLET, RADIUS, CONE, TOP = 0.014, 0.05, 0.04, 0.25  # m


def mesh():
    """The OBJ text of cone and cylinder."""
    line = [(OUTLET + (RADIUS - OUTLET) * i / 8, CONE * i / 8) for i in range(9)]
    line += [(RADIUS, CONE + (TOP - CONE) * i / 24) for i in range(1, 25)]
    return obj_text(line, AROUND)


def flat_walls():
    """Half-spaces around the cylinder, and a panel on each side of the cone."""
    walls = []
    for side in range(SIDES):
        angle = 2 * math.pi * side / SIDES
        out, along = (math.cos(angle), math.sin(angle)), (-math.sin(angle), math.cos(angle))
        walls.append(f"HalfSpace(point: ({RADIUS * out[0]!r}, {RADIUS * out[1]!r}, 0.0), normal: ({-out[0]!r}, {-out[1]!r}, 0.0))")
        half = RADIUS * math.tan(math.pi / SIDES)
        corner = [OUTLET * out[k] - half * along[k] for k in range(2)]
        slope = [(RADIUS - OUTLET) * out[k] for k in range(2)]
        walls.append(f"Panel(corner: ({corner[0]!r}, {corner[1]!r}, 0.0), along: ({slope[0]!r}, {slope[1]!r}, {CONE!r}), "
                     f"across: ({2 * half * along[0]!r}, {2 * half * along[1]!r}, 0.0))")
    return ",\n        ".join(walls) + ","


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--siloflow", default=ROOT / "target/release/siloflow")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--until", default="0.6", help="s")
    parser.add_argument("--core", default="0")
    args = parser.parse_args()
    text = (ROOT / "scenes/round-silo.ron").read_text()
    start, end = text.index("        Cylinder("), text.index("        Annulus(")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "silo.obj").write_text(mesh())
        walls = {
            "cylinder and cone": text[start:end],
            f"{SIDES} half-spaces, {SIDES} panels": f"        {flat_walls()}\n",
            "8192 triangles": '        Mesh(file: "silo.obj", unit: Metre),\n',
        }
        times = {name: [] for name in walls}
        for number, (name, wall) in enumerate(walls.items()):
            (folder / f"{number}.ron").write_text(text[:start] + wall + text[end:])
        for _ in range(args.rounds):
            for number, name in enumerate(walls):
                command = ["taskset", "-c", args.core, args.siloflow, "run", folder / f"{number}.ron", "--until", args.until,
                           "--set", "pictures=None", "--out", folder / "out", "--force", "--quiet", "--json", "--threads", "1"]
                summary = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
                times[name].append(1e9 / summary["performance"]["particle_steps_per_s"])
        first = next(iter(times.values()))
        for name, own in times.items():
            ratio = statistics.median(a / b for a, b in zip(own, first, strict=True))
            print(f"{name:32s} {statistics.median(own):7.1f} ns per particle-step, ratio {ratio:.2f}")


if __name__ == "__main__":
    main()
