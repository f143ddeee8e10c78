#!/usr/bin/env python3
"""A bed of 10,000 frictional spheres in siloflow and in LAMMPS, from the same initial states: packing, contacts, floor force.

    python3 w2.py --siloflow target/release/siloflow --lmp lmp [--seeds 5]
    python3 w2.py --lmp lmp --only lammps              (writes w2-lammps.csv)
    python3 w2.py --siloflow PATH --only siloflow      (writes w2-siloflow.csv, compares with a w2-lammps.csv kept before)

Needs numpy, and LAMMPS with its GRANULAR package (29Sep2021 was used). About a minute and a half a seed in LAMMPS.

d = 1 mm, 2500 kg/m3, k_n = 2e5 m g/d, k_t = 2/7 k_n, e = 0.55 for a pair (gamma_n on m_eff, so other at the floor),
gamma_t = gamma_n/2, mu = 0.5, normal force may attract, lever = radius; periodic in x and y with L = 27 d, floor z = 0,
g = 9.81 m/s2, dt = 2.5e-6 s. A simple cubic lattice of spacing 1.08 d, 25 x 25 x 16, each grain displaced by up to
0.035 d and pushed by up to 0.05 m/s, falls together for 0.2 s without any other damping.

Figures, by the same code for both programs from the final positions, except the force:
  packing       solid volume fraction between 3 d and 10 d above the floor (sphere slices integrated exactly)
  coordination  touching neighbours a grain, the floor counted as one
  floor_fall    mean force on the floor over the weight while the bed collapses, 0 to 0.03 s
  floor_rest    the same at rest, over the last 0.05 s
The runs are chaotic, so only means over seeds compare: PASS if they differ by at most 3 combined standard errors. At rest
the momentum left in the bed is all that keeps floor_rest from 1 (by some 1e-5), so there 1e-4 passes too. With five seeds
a figure fails by chance once in 60 runs (Student's t, 8 degrees of freedom), with ten once in 130.
"""

import argparse
import csv
import math
import pathlib
import subprocess
import sys
import time

import numpy as np

D, DENSITY, GRAVITY = 1.0e-3, 2500.0, 9.81
R = 0.5 * D
MASS = 4.0 * math.pi / 3.0 * R * R * R * DENSITY  # as LAMMPS forms it
PITCH, COLUMNS, LAYERS = 1.08 * D, 25, 16
SIDE = COLUMNS * PITCH
GRAINS = COLUMNS * COLUMNS * LAYERS
K_N = 2.0e5 * MASS * GRAVITY / D
K_T = 2.0 / 7.0 * K_N
FRICTION = 0.5
DECREMENT = -math.log(0.55)
GAMMA_N = 2.0 * math.sqrt(2.0 * K_N / MASS) * DECREMENT / math.hypot(math.pi, DECREMENT)
GAMMA_T = 0.5 * GAMMA_N
DT, EVERY = 2.5e-6, 100  # s; steps over which a reading of the force on the floor is averaged
STEPS, FALL, REST = 80_000, 0.03, 0.05  # steps; s; s
SLAB = (3.0 * D, 10.0 * D)
FIGURES = ("packing", "coordination", "floor_fall", "floor_rest")
OTHERS = ("kinetic_per_mgd", "seconds")


def initial_state(seed):
    """Positions, velocities; no two grains touch: neighbours start at least 1.08 d - 0.07 d apart."""
    draw = np.random.Generator(np.random.PCG64(seed))
    k, j, i = np.meshgrid(np.arange(LAYERS), np.arange(COLUMNS), np.arange(COLUMNS), indexing="ij")
    lattice = (np.stack([i.ravel(), j.ravel(), k.ravel()], 1) + 0.5) * PITCH
    x = lattice + draw.uniform(-0.035, 0.035, (GRAINS, 3)) * D
    v = draw.uniform((-0.05, -0.05, -0.05), (0.05, 0.05, 0.0), (GRAINS, 3))
    return x, v


def cells(row):
    return " ".join(f"{value:.17g}" for value in row)


def run(program, arguments, folder):
    name, *options = program.split()
    command = [str(pathlib.Path(name).resolve()) if "/" in name else name, *options, *arguments]
    with open(folder / "log.txt", "w") as log:
        done = subprocess.run(command, cwd=folder, stdout=log, stderr=subprocess.STDOUT)
    if done.returncode:
        sys.exit(f"{' '.join(command)} failed, see {folder}/log.txt")


def lammps(folder, seed, command):
    """Final position and velocity of each grain, and the floor's force [s, N] through time."""
    x, v = initial_state(seed)
    with open(folder / "bed.data", "w") as out:
        out.write(f"seed {seed}\n\n{GRAINS} atoms\n1 atom types\n0 {SIDE:.17g} xlo xhi\n0 {SIDE:.17g} ylo yhi\n0 {30 * D:.17g} zlo zhi\n")
        out.write("\nAtoms # sphere\n\n")
        out.writelines(f"{n} 1 {D:.17g} {DENSITY:.17g} {cells(row)}\n" for n, row in enumerate(x, 1))
        out.write("\nVelocities\n\n")
        out.writelines(f"{n} {cells(row)} 0 0 0\n" for n, row in enumerate(v, 1))
    law = f"{K_N:.17g} {K_T:.17g} {GAMMA_N:.17g} {GAMMA_T:.17g} {FRICTION} 1"
    (folder / "bed.in").write_text(f"""\
units si
boundary p p f
atom_style sphere
newton off
comm_modify vel yes
read_data bed.data
pair_style gran/hooke/history {law}
pair_coeff * *
neighbor {0.1 * D:.17g} bin
neigh_modify every 1 delay 0 check yes
fix move all nve/sphere
fix weight all gravity {GRAVITY} vector 0 0 -1
fix floor all wall/gran hooke/history {law} zplane 0 NULL contacts
timestep {DT}
compute lift all reduce sum f_floor[4]
fix force all ave/time 1 {EVERY} {EVERY} c_lift format " %.17g" file floor.txt
compute touching all contact/atom
compute contacts all reduce ave c_touching
compute spin all erotate/sphere
thermo_style custom step atoms ke c_spin c_contacts
thermo_modify norm no lost error
thermo 4000
run {STEPS}
write_dump all custom final.dump id x y z vx vy vz modify sort id format float %.17g
write_data settled.data nocoeff
""")
    run(command, ["-in", "bed.in", "-log", "none"], folder)
    final = np.loadtxt(folder / "final.dump", skiprows=9)
    floor = np.loadtxt(folder / "floor.txt")
    return final[:, 1:4], final[:, 4:7], floor * (DT, 1.0)


def number(value):
    text = repr(float(value))
    return text if "." in text else text.replace("e", ".0e")


def siloflow(folder, seed, command):
    """The same, from siloflow."""
    x, v = initial_state(seed)
    with open(folder / "bed.csv", "w") as out:
        out.write("id,radius,mass,x,y,z,vx,vy,vz,wx,wy,wz\n")
        for n, (a, b) in enumerate(zip(x, v), 1):
            out.write(f"{n},{R:.17g},{MASS:.17g},{cells(a).replace(' ', ',')},{cells(b).replace(' ', ',')},0,0,0\n")
    (folder / "bed.ron").write_text(f"""\
(
    space: Solid,
    gravity: (0.0, 0.0, {number(-GRAVITY)}),
    periodic: (x: (0.0, {number(SIDE)}), y: (0.0, {number(SIDE)})),
    contact: Linear(
        k: {number(K_N)},
        damping: PerMass({number(GAMMA_N)}),
        attraction: Allowed,
        tangential: Spring(k: {number(K_T)}, damping: PerMass({number(GAMMA_T)}), friction: {number(FRICTION)}),
        lever: Radius,
    ),
    walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))],
    grains: (file: "bed.csv"),
    integrator: Verlet, step: Fixed({number(DT)}),
    until: {number(STEPS * DT)},
    series: (interval: {number(EVERY * DT)}),
    pictures: None,
)
""")
    run(command, ["run", "bed.ron", "--force", "--out", "out"], folder)
    final = read_columns(folder / "out" / "state.csv", ("id", "x", "y", "z", "vx", "vy", "vz"))
    final = final[np.argsort(final[:, 0])]
    walls = read_columns(folder / "out" / "walls.csv", ("wall", "time_s", "fz_n"))
    floor = walls[walls[:, 0] == 1][:, 1:] * (1.0, -1.0)
    return final[:, 1:4], final[:, 4:7], floor


def read_columns(path, names):
    with open(path, newline="") as text:
        rows = csv.DictReader(line for line in text if not line.startswith("#"))
        return np.array([[float(row[name]) for name in names] for row in rows])


def packing(x):
    """Solid fraction of the slab: of a sphere at height c, pi (R^2 - (z - c)^2) integrated over the z inside both."""
    low, high = (np.clip(edge - x[:, 2], -R, R) for edge in SLAB)
    volume = math.pi * (R * R * (high - low) - (high**3 - low**3) / 3.0)
    return volume.sum() / (SIDE * SIDE * (SLAB[1] - SLAB[0]))


def touching_pairs(x):
    """How many pairs are closer than d: a table of cells wider than d, each against itself and half of its neighbours."""
    x = x.copy()
    x[:, :2] %= SIDE
    n = int(SIDE / (1.001 * D))
    layers = int(x[:, 2].max() / D) + 2
    cell = np.minimum((x[:, :2] / SIDE * n).astype(int), n - 1)
    key = (np.maximum(x[:, 2] / D, 0.0).astype(int) * n + cell[:, 1]) * n + cell[:, 0]
    order = np.argsort(key, kind="stable")
    count = np.bincount(key, minlength=n * n * layers)
    slot = np.arange(len(x)) - np.repeat(np.cumsum(count) - count, count)
    table = np.full((layers + 2, n, n, count.max()), -1)  # an empty layer below and one above
    table.reshape(-1, count.max())[key[order] + n * n, slot] = order
    pairs = 0
    for dz, dy, dx in [(0, 0, 0), (0, 0, 1)] + [(0, 1, dx) for dx in (-1, 0, 1)] + [(1, dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1)]:
        other = np.roll(table, (-dz, -dy, -dx), (0, 1, 2))
        i, j = (np.broadcast_to(side, (*table.shape, count.max())) for side in (table[..., :, None], other[..., None, :]))
        both = (i >= 0) & (j >= 0) if (dz, dy, dx) != (0, 0, 0) else (i >= 0) & (j > i)
        gap = x[i[both]] - x[j[both]]
        gap[:, :2] -= SIDE * np.round(gap[:, :2] / SIDE)
        pairs += int(((gap * gap).sum(1) < D * D).sum())
    return pairs


def figures(x, v, floor, seconds):
    weight = GRAINS * MASS * GRAVITY
    when, force = floor[:, 0], floor[:, 1] / weight
    half = 0.5 * EVERY * DT
    return {
        "packing": packing(x),
        "coordination": (2 * touching_pairs(x) + int((x[:, 2] < R).sum())) / len(x),
        # A reading is the mean over the steps since the one before; at time 0 there are none.
        "floor_fall": force[(when > half) & (when < FALL + half)].mean(),
        "floor_rest": force[when > STEPS * DT - REST + half].mean(),
        "kinetic_per_mgd": 0.5 * (v * v).sum(1).mean() / (GRAVITY * D),
        "seconds": seconds,
    }


def all_seeds(program, name, command, options):
    rows = []
    for seed in range(1, options.seeds + 1):
        folder = pathlib.Path(options.work) / f"{name}-{seed}"
        folder.mkdir(parents=True, exist_ok=True)
        start = time.perf_counter()
        x, v, floor = program(folder, seed, command)
        if len(x) != GRAINS or not np.isfinite(x).all():
            sys.exit(f"{name}, seed {seed}: {len(x)} grains at the end instead of {GRAINS}, or places that are no numbers")
        rows.append({"seed": seed, **figures(x, v, floor, time.perf_counter() - start)})
        print(name, " ".join(f"{key}={value:.7g}" for key, value in rows[-1].items()), flush=True)
    with open(f"w2-{name}.csv", "w", newline="") as out:
        writer = csv.DictWriter(out, ["seed", *FIGURES, *OTHERS])
        writer.writeheader()
        writer.writerows(rows)
    return rows


def kept(path):
    if not pathlib.Path(path).exists():
        return None
    with open(path, newline="") as text:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(text)]


def mean(rows, figure):
    values = np.array([row[figure] for row in rows])
    return values.mean(), values.std(ddof=1) / math.sqrt(len(values)) if len(values) > 1 else math.nan


def compare(ours, theirs):
    """Prints the table; true if every figure passes."""
    print(f"{'':14s}{'siloflow':>22s}{'LAMMPS':>24s}   difference / combined standard error")
    passed = True
    for figure in FIGURES:
        (a, da), (b, db) = mean(ours, figure), mean(theirs, figure)
        error = math.hypot(da, db)
        good = abs(a - b) <= max(3.0 * error, 1.0e-4 if figure == "floor_rest" else 0.0)
        passed &= good
        print(f"{figure:14s}{a:12.6f} +- {da:.1e}{b:14.6f} +- {db:.1e}   {(a - b) / error:+6.2f}  {'PASS' if good else 'FAIL'}")
    return passed


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--siloflow", help="the siloflow program, with options if wanted")
    parser.add_argument("--lmp", default="lmp", help="the LAMMPS program, with options if wanted")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--only", choices=("lammps", "siloflow"))
    parser.add_argument("--work", default="w2-work", help="folder for inputs and outputs")
    options = parser.parse_args()
    if options.only != "lammps" and not options.siloflow:
        parser.error("--siloflow PATH is needed")
    if options.only == "siloflow":
        theirs = kept("w2-lammps.csv")
    else:
        theirs = all_seeds(lammps, "lammps", options.lmp, options)
    if options.only == "lammps":
        for figure in FIGURES:
            print(f"{figure:14s}{mean(theirs, figure)[0]:12.6f} +- {mean(theirs, figure)[1]:.1e}")
        return
    ours = all_seeds(siloflow, "siloflow", options.siloflow, options)
    if theirs is None:
        sys.exit("no w2-lammps.csv to compare with: run without --only")
    if not compare(ours, theirs):
        sys.exit(1)


if __name__ == "__main__":
    main()
