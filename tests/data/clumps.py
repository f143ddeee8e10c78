#!/usr/bin/env python3
"""Ten rigid clumps of three spheres in a box with friction: the same start for siloflow and for LAMMPS, and LAMMPS's frames as CSV.

    python3 clumps.py state SILOFLOW     writes clumps_initial.csv, clumps.data and clumps.rigid (needs numpy)
    lmp -in clumps.in -var dt 4e-6       writes clumps-4e-6.dump (LAMMPS 29Sep2021), for each step
    python3 clumps.py frames             writes clumps_frames.csv from the dumps of all steps

SILOFLOW is the program; it tells the mass, the moments of inertia and the spheres of the shape in its principal axes. SI units throughout.
"""

import random
import re
import subprocess
import sys
from pathlib import Path

STEPS = ("4e-6", "2e-6", "1e-6")
SIDE = 0.03
DENSITY = 2500.0
CLUMPS = 10
SPHERES = ((0.0, 0.0, 0.0, 2.0e-3), (2.5e-3, 0.4e-3, 0.0, 1.8e-3), (1.0e-3, 1.4e-3, 1.0e-3, 1.2e-3))
# Frames every 2 ms up to 20 ms.
FRAME = 2.0e-3
END = 0.02
SCENE = Path("clumps.ron")


def shape(siloflow):
    """Mass, principal moments, and the spheres in principal axes."""
    text = subprocess.run([siloflow, "explain", SCENE], check=True, capture_output=True, text=True).stdout
    mass = float(re.search(r"mass (\S+) kg", text).group(1))
    radius = 0.5 * float(re.search(r"equal volume (\S+) m", text).group(1))
    moments = [float(x) for x in re.search(r"inertia (.*?) kg m\^2", text).group(1).split(", ")]
    places = re.search(r"place and radius, m: (.*)", text).group(1).split("; ")
    spheres = [[float(x) for x in re.findall(r"[-+0-9.e]+", place)] for place in places]
    return mass, radius, moments, spheres


def state(siloflow):
    import numpy as np

    mass, radius, moments, spheres = shape(siloflow)
    own = np.array(spheres)[:, :3]
    described = np.array(SPHERES)[:, :3]
    # The rotation from principal axes to the axes of the shape as described (Kabsch).
    a, b = own - own.mean(0), described - described.mean(0)
    u, _, vt = np.linalg.svd(a.T @ b)
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(vt.T @ u.T))])
    axes = vt.T @ flip @ u.T
    assert np.abs(axes @ a.T - b.T).max() < 1e-12
    reach = max(np.linalg.norm(s[:3]) + s[3] for s in spheres)
    draw = random.Random(5)
    bodies = []
    while len(bodies) < CLUMPS:
        x = np.array([draw.uniform(reach + 1e-4, SIDE - reach - 1e-4) for _ in range(2)] + [draw.uniform(reach + 1e-4, 0.03)])
        if all(np.linalg.norm(x - y) > 2 * reach + 2e-4 for y, *_ in bodies):
            v = np.array([draw.uniform(-0.6, 0.6), draw.uniform(-0.6, 0.6), draw.uniform(-1.0, 0.2)])
            w = np.array([draw.uniform(-100.0, 100.0) for _ in range(3)])
            q = np.array([draw.gauss(0.0, 1.0) for _ in range(4)])
            bodies.append((x, v, w, q / np.linalg.norm(q)))
    with open("clumps_initial.csv", "w") as grains, open("clumps.data", "w") as data, open("clumps.rigid", "w") as rigid:
        grains.write("id,shape,scale,mass,x,y,z,vx,vy,vz,wx,wy,wz,qw,qx,qy,qz\n")
        count = CLUMPS * len(spheres)
        data.write(f"Ten clumps, SI; clumps.py state wrote it\n\n{count} atoms\n1 atom types\n")
        data.write(f"0 {SIDE} xlo xhi\n0 {SIDE} ylo yhi\n0 0.3 zlo zhi\n\nAtoms # sphere\n\n")
        rigid.write(f"{CLUMPS}\n")
        molecules, velocities = [], []
        atom = 0
        for number, (x, v, w, q) in enumerate(bodies, 1):
            written = [*x, *v, *w, *q]
            grains.write(f"{number},bean,1,{mass:.17g}," + ",".join(f"{a:.17g}" for a in written) + "\n")
            turn = rotation(np, q) @ axes
            for *at, r in spheres:
                atom += 1
                place = x + turn @ np.array(at)
                data.write(f"{atom} 1 {2 * r:.17g} {DENSITY:.17g} " + " ".join(f"{a:.17g}" for a in place) + "\n")
                molecules.append(f"{atom} {number}\n")
                speed = v + np.cross(w, turn @ np.array(at))
                velocities.append(f"{atom} " + " ".join(f"{a:.17g}" for a in [*speed, *w]) + "\n")
            inertia = turn @ np.diag(moments) @ turn.T
            spin = inertia @ w
            tensor = [inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]]
            rigid.write(" ".join(f"{a:.17g}" for a in [number, mass, *x, *tensor, *v, *spin]).replace(".0 ", " ") + " 0 0 0\n")
        data.write("\nVelocities\n\n" + "".join(velocities) + "\nMolecules\n\n" + "".join(molecules))


def rotation(np, q):
    w, x, y, z = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def frames():
    """One row a sphere: LAMMPS tells no centres of bodies, and the places of three spheres tell a body's place and orientation."""
    with open("clumps_frames.csv", "w") as out:
        out.write("dt,time,clump,sphere,x,y,z,vx,vy,vz,wx,wy,wz\n")
        for dt in STEPS:
            lines = iter(open(f"clumps-{dt}.dump").read().splitlines())
            for line in lines:
                if line.startswith("ITEM: TIMESTEP"):
                    time = int(next(lines)) * float(dt)
                elif line.startswith("ITEM: NUMBER"):
                    count = int(next(lines))
                elif line.startswith("ITEM: ATOMS"):
                    for _ in range(count):
                        number, *numbers = next(lines).split()
                        clump, sphere = divmod(int(number) - 1, len(SPHERES))
                        out.write(f"{dt},{time:.6g},{clump + 1},{sphere}," + ",".join(numbers) + "\n")


if __name__ == "__main__":
    state(sys.argv[2]) if sys.argv[1] == "state" else frames()
