#!/usr/bin/env python3
"""Twenty frictional spheres in a box: initial state, LAMMPS's frames as CSV, and a second implementation to hold against them.

    python3 friction.py state     writes friction.data (what friction.in reads)
    lmp -in friction.in           writes friction.dump (LAMMPS 29Sep2021)
    python3 friction.py frames    writes friction_initial.csv and friction_frames.csv
    python3 friction.py check     follows the frames with the scheme below (needs numpy), prints the distances

SI units throughout.
"""

import random
import sys

DT = 2.0e-6
K_N, K_T = 1.0e5, 28571.428571428572
GAMMA_N, GAMMA_T = 4000.0, 1500.0
FRICTION = 0.5
GRAVITY = 9.81
SIDE = 0.032
RADII = (0.004, 0.003)
DENSITY = 2500.0
GRAINS = 20
HEADER = "x,y,z,vx,vy,vz,wx,wy,wz"


def state(seed=11):
    """Spheres of two radii that touch neither each other nor a wall, thrown about and spinning; the first five start just
    above the floor, so that some contacts last."""
    draw = random.Random(seed)
    grains = []
    while len(grains) < GRAINS:
        r = RADII[len(grains) % 2]
        x = [draw.uniform(r + 2e-4, SIDE - r - 2e-4), draw.uniform(r + 2e-4, SIDE - r - 2e-4), draw.uniform(r + 2e-4, 0.034)]
        rolls = len(grains) < 5
        if rolls:
            x[2] = r + 2e-6
        gap = min((sum((a - b) ** 2 for a, b in zip(x, y)) ** 0.5 - r - q for q, y, _, _ in grains), default=1.0)
        if gap > 2e-4:
            v = [draw.uniform(-0.8, 0.8), draw.uniform(-0.8, 0.8), 0.0 if rolls else draw.uniform(-1.0, 0.2)]
            w = [draw.uniform(-250.0, 250.0) for _ in range(3)]
            grains.append((r, x, v, w))
    with open("friction.data", "w") as out:
        out.write(f"Twenty spheres, SI; friction.py state wrote it\n\n{GRAINS} atoms\n1 atom types\n")
        out.write(f"0 {SIDE} xlo xhi\n0 {SIDE} ylo yhi\n0 0.3 zlo zhi\n\nAtoms # sphere\n\n")
        for i, (r, x, _, _) in enumerate(grains, 1):
            out.write(f"{i} 1 {2 * r:.17g} {DENSITY:.17g} " + " ".join(f"{a:.17g}" for a in x) + "\n")
        out.write("\nVelocities\n\n")
        for i, (_, _, v, w) in enumerate(grains, 1):
            out.write(f"{i} " + " ".join(f"{a:.17g}" for a in v + w) + "\n")


def dump_frames(path="friction.dump"):
    """(step, rows of text) of each frame, as LAMMPS printed them: id radius mass x y z vx vy vz wx wy wz."""
    lines = iter(open(path).read().splitlines())
    for line in lines:
        if line.startswith("ITEM: TIMESTEP"):
            step = int(next(lines))
        elif line.startswith("ITEM: NUMBER"):
            count = int(next(lines))
        elif line.startswith("ITEM: ATOMS"):
            yield step, [next(lines).split() for _ in range(count)]


def frames():
    with open("friction_initial.csv", "w") as first, open("friction_frames.csv", "w") as out:
        first.write(f"id,radius,mass,{HEADER}\n")
        out.write(f"time,id,{HEADER}\n")
        for step, rows in dump_frames():
            for row in rows:
                if step == 0:
                    first.write(",".join(row) + "\n")
                out.write(f"{step * DT:.6g},{row[0]}," + ",".join(row[3:]) + "\n")


def cross(np, a, b):
    return np.stack([a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1], a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
                     a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]], 1)


class Bed:
    """All pairs and all walls, one row each; a wall is a partner at rest without mass, spin or radius."""

    def __init__(self, np, rows, **law):
        self.np = np
        self.law = {"dt": DT, "mu": FRICTION, "gamma_t": GAMMA_T, "k_t": K_T, "contact_point": False, "project": True, "spring_cap": False} | law
        self.r, self.m = rows[:, 1].copy(), rows[:, 2].copy()
        self.x, self.v, self.w = rows[:, 3:6].copy(), rows[:, 6:9].copy(), rows[:, 9:12].copy()
        n = len(rows)
        i, j = np.triu_indices(n, 1)
        planes = [(0, 0.0, 1.0), (0, SIDE, -1.0), (1, 0.0, 1.0), (1, SIDE, -1.0), (2, 0.0, 1.0)]
        self.pairs = len(i)
        self.i = np.concatenate([i] + [np.arange(n)] * len(planes))
        self.j = j
        self.axis = np.repeat([p[0] for p in planes], n)
        self.offset = np.repeat([p[1] for p in planes], n)
        self.sign = np.repeat([p[2] for p in planes], n)
        radius_j = np.concatenate([self.r[j], np.zeros(n * len(planes))])
        self.radius_i, self.radius_j = self.r[self.i], radius_j
        self.reach = self.radius_i + radius_j
        self.meff = np.concatenate([self.m[i] * self.m[j] / (self.m[i] + self.m[j])] + [self.m] * len(planes))
        self.s = np.zeros((len(self.i), 3))
        self.was = np.zeros(len(self.i), bool)
        self.counts = {"contacts": 0, "with_walls": 0, "sliding": 0, "sticking": 0, "largest_overlap": 0.0}
        self.kinds = np.zeros((len(self.i), 2), bool)
        self.kind_counts = {"only_sliding": 0, "only_sticking": 0, "both": 0}
        self.forces(advance=False)

    def forces(self, advance):
        np, law, dt = self.np, self.law, self.law["dt"]
        p = self.pairs
        d = np.zeros((len(self.i), 3))
        d[:p] = self.x[self.i[:p]] - self.x[self.j]
        wall = np.arange(p, len(self.i))
        d[wall, self.axis] = self.x[self.i[p:], self.axis] - self.offset
        distance = np.sqrt((d * d).sum(1))
        touching = distance < self.reach
        self.s[~touching] = 0.0
        self.end_contacts(self.was & ~touching)
        c = np.nonzero(touching)[0]
        force, torque = self.m[:, None] * np.array([0.0, 0.0, -GRAVITY]), np.zeros_like(self.w)
        if len(c):
            i, pair = self.i[c], c < p
            j = self.j[c[pair]]
            n = d[c] / distance[c, None]
            overlap = self.reach[c] - distance[c]
            v, wi, wj = self.v[i].copy(), self.w[i], np.zeros((len(c), 3))
            v[pair] -= self.v[j]
            wj[pair] = self.w[j]
            li, lj = self.radius_i[c], self.radius_j[c]
            if law["contact_point"]:
                li, lj = (np.where(pair, li - overlap * lj / (li + lj), li - overlap), lj - overlap * li / (li + lj))
            v_n = (v * n).sum(1)
            v_t = v - v_n[:, None] * n - cross(np, li[:, None] * wi + lj[:, None] * wj, n)
            f_n = K_N * overlap - self.meff[c] * GAMMA_N * v_n
            c_t = (self.meff[c] * law["gamma_t"])[:, None]
            s = self.s[c]
            if advance:
                s = s + v_t * dt
                if law["project"]:
                    s -= (s * n).sum(1)[:, None] * n
            f_t = -law["k_t"] * s - c_t * v_t
            size = np.sqrt((f_t * f_t).sum(1))
            cap = law["mu"] * np.abs(K_N * overlap if law["spring_cap"] else f_n)
            slides = size > cap
            f_t[slides] *= (cap[slides] / size[slides])[:, None]
            s[slides] = -(f_t[slides] + c_t[slides] * v_t[slides]) / law["k_t"]
            if advance:
                self.s[c] = s
                self.count(c, slides, overlap, touching)
            f = f_n[:, None] * n + f_t
            turn = cross(np, n, f_t)
            np.add.at(force, i, f)
            np.add.at(torque, i, -li[:, None] * turn)
            np.subtract.at(force, j, f[pair])
            np.add.at(torque, j, (-lj[:, None] * turn)[pair])
        self.was = touching
        self.acceleration = force / self.m[:, None]
        self.spin_up = torque / (0.4 * self.m * self.r * self.r)[:, None]

    def count(self, c, slides, overlap, touching):
        new = touching & ~self.was
        self.counts["contacts"] += int(new.sum())
        self.counts["with_walls"] += int(new[self.pairs:].sum())
        self.counts["sliding"] += int(slides.sum())
        self.counts["sticking"] += int((~slides).sum())
        self.counts["largest_overlap"] = max(self.counts["largest_overlap"], float((overlap / self.radius_i[c]).max()))
        self.kinds[c[slides], 0] = True
        self.kinds[c[~slides], 1] = True

    def end_contacts(self, ended):
        for slid, stuck in self.kinds[ended]:
            self.kind_counts["both" if slid and stuck else "only_sliding" if slid else "only_sticking"] += 1
        self.kinds[ended] = False

    def run_to(self, step, now):
        half, dt = 0.5 * self.law["dt"], self.law["dt"]
        for _ in range(now, step):
            self.v += half * self.acceleration
            self.w += half * self.spin_up
            self.x += dt * self.v
            self.forces(advance=True)
            self.v += half * self.acceleration
            self.w += half * self.spin_up
        return step


def follow(np, label, initial, reference, **law):
    bed, now, distances = Bed(np, initial, **law), 0, []
    shift = 0.0
    for step, rows in reference:
        now = bed.run_to(step, now)
        shift = float(np.sqrt(((bed.x - rows[:, 3:6]) ** 2).sum(1)).max())
        spin = float(np.abs(bed.w - rows[:, 9:12]).max())
        distances.append((step * DT, shift, spin))
    print(f"{label:34s}" + " ".join(f"{s:.0e}" for _, s, _ in distances[1:]) + f"  m; spin at the end {distances[-1][2]:.0e} rad/s", flush=True)
    return bed


def check():
    import numpy as np

    reference = [(step, np.array(rows, float)) for step, rows in dump_frames()]
    initial = reference[0][1]
    print("largest distance from LAMMPS at " + " ".join(f"{step * DT:g}" for step, _ in reference[1:]) + " s")
    bed = follow(np, "the same scheme", initial, reference)
    print(bed.counts, bed.kind_counts, "still touching:", int(bed.was.sum()))
    moved = initial.copy()
    moved[:, 3] += 1e-14
    follow(np, "x of all off by 1e-14 m", moved, reference)
    if "laws" in sys.argv:
        follow(np, "lever at the contact point", initial, reference, contact_point=True)
        follow(np, "gamma_t = 0", initial, reference, gamma_t=0.0)
        follow(np, "spring not turned with the contact", initial, reference, project=False)
        follow(np, "cap mu k delta", initial, reference, spring_cap=True)
        follow(np, "mu = 0.5001", initial, reference, mu=0.5001)
        follow(np, "k_t + 1e-6", initial, reference, k_t=K_T * (1 + 1e-6))


if __name__ == "__main__":
    {"state": state, "frames": frames, "check": check}[sys.argv[1]]()
