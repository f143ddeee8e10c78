#!/usr/bin/env python3
"""Ten spheres in a cylinder, in a cone and in a sphere: initial state, and LAMMPS's frames as CSV; see round-walls.in. SI units."""

import random
import sys

from friction import DT, HEADER

DENSITY, GRAINS = 2500.0, 10


def state():
    """Spheres of two radii near the axis, that fly outwards and spin."""
    draw = random.Random(7)
    with open("round-walls.data", "w") as out:
        out.write(f"Ten spheres; round-walls.py state wrote it\n\n{GRAINS} atoms\n1 atom types\n")
        out.write("-0.1 0.1 xlo xhi\n-0.1 0.1 ylo yhi\n-0.1 0.1 zlo zhi\n\nAtoms # sphere\n\n")
        for i in range(GRAINS):
            x = [draw.uniform(-4e-3, 4e-3), draw.uniform(-4e-3, 4e-3), 9e-3 * (i - 0.5 * (GRAINS - 1)) * 0.9]
            out.write(f"{i + 1} 1 {2 * (0.004, 0.003)[i % 2]:.17g} {DENSITY:.17g} " + " ".join(f"{a:.17g}" for a in x) + "\n")
        out.write("\nVelocities\n\n")
        for i in range(GRAINS):
            v = [draw.uniform(-3.0, 3.0), draw.uniform(-3.0, 3.0), draw.uniform(-0.5, 0.5)]
            w = [draw.uniform(-250.0, 250.0) for _ in range(3)]
            out.write(f"{i + 1} " + " ".join(f"{a:.17g}" for a in v + w) + "\n")


def frames():
    with open("round_walls_initial.csv", "w") as first, open("round_walls_frames.csv", "w") as out:
        first.write(f"id,radius,mass,{HEADER}\n")
        out.write(f"shape,time,id,{HEADER}\n")
        for shape in ("cylinder", "cone", "sphere"):
            lines = iter(open(f"{shape}.dump").read().splitlines())
            for line in lines:
                if line.startswith("ITEM: TIMESTEP"):
                    step = int(next(lines))
                elif line.startswith("ITEM: ATOMS"):
                    rows = [next(lines).split() for _ in range(GRAINS)]
                    for row in rows:
                        if step == 0 and shape == "cylinder":
                            first.write(",".join(row) + "\n")
                        out.write(f"{shape},{step * DT:.6g},{row[0]}," + ",".join(row[3:]) + "\n")


if __name__ == "__main__":
    {"state": state, "frames": frames}[sys.argv[1]]()
