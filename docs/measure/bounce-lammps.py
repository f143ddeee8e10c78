#!/usr/bin/env python3
"""Error of the restitution of a damped bounce against the time step, in LAMMPS and, if wanted, in siloflow from the same states.

    python3 bounce-lammps.py lmp [--siloflow target/release/siloflow] [--csv bounce-lammps.csv]

Two equal spheres meet head-on at 1 m/s: R = 0.04 m, m = 0.16 kg, k = 1e5 N/m, linear spring and dashpot, attraction
allowed, so that the exact restitution is e = exp(-pi beta/w), beta = c/(2 m_eff), w = sqrt(k/m_eff - beta^2), and the
contact lasts t_c = pi/w. The time step is t_c/(n + pi/8), which never divides t_c; the error is the root mean square over
40 phases, that is, shares of a step by which the contact begins before the first step that sees it. The 40 pairs run side by
side, 0.2 m apart. Prints, for each e, the t_c/dt that gives a wanted error, interpolated between the steps run (both axes
logarithmic; "-" where none of them reaches it), and writes every error to the csv. LAMMPS 29Sep2021 was used. A minute.
"""

import argparse
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

K, R, MASS, SPEED = 1.0e5, 0.04, 0.16, 1.0  # N/m, m, kg, m/s
REDUCED = 0.5 * MASS
PHASES, APART = 40, 0.2  # m
STEPS_A_CONTACT = (5, 7, 10, 14, 20, 28, 50, 100, 200, 500, 1000, 2000, 5000)
RESTITUTIONS = (0.9, 0.5, 0.2)
WANTED = (1.0e-2, 1.0e-3, 1.0e-4)


def damping(e):
    """beta = c/(2 m_eff) [1/s] and t_c [s]; from e = exp(-pi beta/w) and w^2 + beta^2 = k/m_eff."""
    decrement, frequency = -math.log(e), math.sqrt(K / REDUCED)
    beta = frequency * decrement / math.hypot(math.pi, decrement)
    return beta, math.pi / math.sqrt(frequency * frequency - beta * beta)


def grains(dt):
    """(x, y, v_x) of every grain, pair after pair; a pair closes its gap within the second step."""
    for phase in range(PHASES):
        gap = SPEED * dt * (1.0 + (phase + 0.5) / PHASES)
        for side in (-1.0, 1.0):
            yield 0.5 + side * (R + 0.5 * gap), APART * (phase + 0.5), -0.5 * side * SPEED


def run(command, arguments, folder):
    name, *options = command.split()
    name = str(pathlib.Path(name).resolve()) if "/" in name else name
    done = subprocess.run([name, *options, *arguments], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{command} failed: {done.stdout[-800:]}{done.stderr[-800:]}")


def lammps(command, folder, beta, dt, steps):
    """v_x of every grain after the bounce."""
    density = MASS / (4.0 / 3.0 * math.pi * R**3)
    with open(folder / "bounce.data", "w") as out:
        out.write(f"pairs\n\n{2 * PHASES} atoms\n1 atom types\n0 1 xlo xhi\n0 {APART * PHASES:.17g} ylo yhi\n-0.5 0.5 zlo zhi\n")
        out.write("\nAtoms # sphere\n\n")
        out.writelines(f"{i} 1 {2 * R:.17g} {density:.17g} {x:.17g} {y:.17g} 0\n" for i, (x, y, _) in enumerate(grains(dt), 1))
        out.write("\nVelocities\n\n")
        out.writelines(f"{i} {v:.17g} 0 0 0 0 0\n" for i, (_, _, v) in enumerate(grains(dt), 1))
    (folder / "bounce.in").write_text(f"""\
units si
boundary f f f
atom_style sphere
newton off
comm_modify vel yes
read_data bounce.data
pair_style gran/hooke {K!r} 0 {2.0 * beta!r} 0 0 0
pair_coeff * *
neighbor 0.01 bin
neigh_modify every 1 delay 0 check yes
fix move all nve
timestep {dt!r}
run {steps}
write_dump all custom final.dump id vx modify sort id format float %.17g
""")
    run(command, ["-in", "bounce.in", "-log", "none"], folder)
    rows = (folder / "final.dump").read_text().splitlines()[9:]
    return [float(row.split()[1]) for row in rows]


def siloflow(command, folder, beta, dt, steps):
    """The same, from siloflow."""
    with open(folder / "pairs.csv", "w") as out:
        out.write("id,radius,mass,x,y,vx,vy\n")
        out.writelines(f"{i},{R},{MASS},{x:.17g},{y:.17g},{v:.17g},0\n" for i, (x, y, v) in enumerate(grains(dt), 1))
    # Half a step short of the end: the step that reaches it is the last.
    (folder / "bounce.ron").write_text(f"""\
(
    gravity: (0.0, 0.0),
    contact: Linear(k: {K!r}, damping: PerMass({2.0 * beta!r}), attraction: Allowed),
    grains: (file: "pairs.csv"),
    integrator: Verlet,
    step: Fixed({dt:.17f}),
    until: {(steps - 0.5) * dt:.17f},
    pictures: None,
)
""")
    run(command, ["run", "bounce.ron", "--force", "--out", "out", "--quiet"], folder)
    with open(folder / "out" / "state.csv", newline="") as text:
        rows = sorted((int(row["id"]), float(row["vx"])) for row in csv.DictReader(line for line in text if line[0] != "#"))
    return [v for _, v in rows]


def errors(program, command, e):
    """(t_c/dt, rms error, mean error) for every step."""
    beta, duration = damping(e)
    rows = []
    for n in STEPS_A_CONTACT:
        n += math.pi / 8.0
        with tempfile.TemporaryDirectory() as folder:
            # Time enough to part even where a coarse step makes the contact last longer.
            v = program(command, pathlib.Path(folder), beta, duration / n, math.ceil(1.6 * n) + 10)
        off = [(right - left) / SPEED - e for left, right in zip(v[::2], v[1::2], strict=True)]
        rows.append((n, math.sqrt(sum(x * x for x in off) / PHASES), sum(off) / PHASES))
    return rows


def steps_for(wanted, rows):
    """The t_c/dt beyond which the error stays below what is wanted."""
    if rows[-1][1] > wanted:
        return None
    for (n, error, _), (finer, smaller, _) in reversed(list(zip(rows, rows[1:]))):
        if error >= wanted > smaller:
            return n * (finer / n) ** (math.log(error / wanted) / math.log(error / smaller))
    return None


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("lmp", help="the LAMMPS program, with options if wanted")
    parser.add_argument("--siloflow", help="the siloflow program")
    parser.add_argument("--csv", default="bounce-lammps.csv")
    options = parser.parse_args()
    programs = [("lammps", lammps, options.lmp)]
    if options.siloflow:
        programs.append(("siloflow", siloflow, options.siloflow))
    with open(options.csv, "w", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(["program", "restitution", "steps_a_contact", "rms_error", "mean_error"])
        needed = {}
        for name, program, command in programs:
            for e in RESTITUTIONS:
                rows = errors(program, command, e)
                writer.writerows([name, e, f"{n:.6f}", f"{rms:.6e}", f"{mean:.6e}"] for n, rms, mean in rows)
                needed[name, e] = [steps_for(wanted, rows) for wanted in WANTED]
    print("t_c/dt for an rms error of" + "".join(f"{wanted:12.0e}" for wanted in WANTED))
    for (name, e), steps in needed.items():
        print(f"{name:9s} e = {e:<12}" + "".join("           -" if n is None else f"{n:12.1f}" for n in steps))
    for name, _, _ in programs:
        means = []
        for column in zip(*(needed[name, e] for e in RESTITUTIONS)):
            means.append(None if None in column else math.prod(column) ** (1.0 / len(column)))
        print(f"{name:9s} geometric mean  " + "".join("           -" if n is None else f"{n:12.1f}" for n in means))


if __name__ == "__main__":
    main()
