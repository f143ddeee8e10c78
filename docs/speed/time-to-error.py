#!/usr/bin/env python3
"""Time to a given error in oblique impacts, LAMMPS and siloflow's default scheme, in one sitting: a table and a figure.

    apt-get install --no-install-recommends lammps
    cargo build --release
    docs/speed/side-by-side.py settle w1-1e4; docs/speed/side-by-side.py settle w2-1e4     (once)
    docs/speed/time-to-error.py                      (writes time-to-error.csv beside it, docs/figures/time-to-error.svg)
    siloflow render docs/figures/time-to-error.svg   (writes docs/figures/time-to-error.png)

**Steps.** Two equal spheres (R = 0.04 m, m = 0.16 kg) meet with 1 m/s along the line of centres and 1 m/s across it, at 40 phases of a step.
The error is that of their relative velocity after the impact and of R times the sum of their spins, added in quadrature, over the
impact speed, as rms over the phases. Each program is measured against its own limit of fine steps (extrapolated), because the
damping of Hertz contacts differs between the programs. With the linear laws both limits agree (printed). Steps per contact for a wanted
error are interpolated (both axes logarithmic) between the steps run; t_c/(n + pi/8) never divides t_c.

**Laws**, all with attraction: linear without friction; linear with friction (mu = 0.5, k_t = 2/7 k, gamma_t = gamma/2); Hertz and
Mindlin (mu = 0.5; LAMMPS: mindlin/force, damping tsuji; its mindlin without /force does not converge, because a contact that
slips in its first step stretches a spring of nearly zero stiffness). e = 0.9, 0.5, 0.2.

**Time.** Steps times the nanoseconds per particle-step that docs/speed/side-by-side.py measures in the beds W1 and W2, both programs
alternately on one core, siloflow with its energy balance. Every case is multiplied by both. --ns reads them from an earlier table.
"""

import argparse
import csv
import math
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
FIGURE = HERE.parent / "figures/time-to-error.svg"
K, R, MASS, PHASES, APART = 1.0e5, 0.04, 0.16, 40, 0.3  # N/m, m, kg, copies, m
YOUNG, POISSON, MU = 4.0e6, 0.3, 0.5  # Pa
SPEED = math.sqrt(2.0)  # m/s
WANTED = (1.0e-2, 1.0e-3, 1.0e-4)
LAWS = ("linear, smooth", "linear, friction", "Hertz, Mindlin")
STEPS = {
    "LAMMPS": (5, 7, 10, 14, 20, 28, 40, 70, 100, 200, 400, 700, 1000, 2000, 4000, 8000),
    "Centred": (5, 6, 7, 8, 10, 12, 14, 17, 20, 25, 30, 40, 50, 70, 100, 140, 200),
}
FINE = {"LAMMPS": (20_000, 1), "Centred": (4_000, 2)}  # steps in a contact; order
COLUMNS = ("law", "restitution", "error", "steps_lammps", "steps_centred", "ns_w1_lammps", "ns_w1_centred", "ns_w2_lammps", "ns_w2_centred",
           "ratio_w1", "ratio_w2")


def gamma(e):
    """gamma_n = c/m_eff, 1/s, and the contact duration, s, of the linear law."""
    decrement, frequency = -math.log(e), math.sqrt(2.0 * K / MASS)
    beta = frequency * decrement / math.hypot(math.pi, decrement)
    return 2.0 * beta, math.pi / math.sqrt(frequency**2 - beta**2)


def duration(law, e):
    if law != LAWS[2]:
        return gamma(e)[1]
    # Of the undamped impact at 1 m/s along the normal.
    stiffness = 4.0 / 3.0 * YOUNG / (2.0 * (1.0 - POISSON**2)) * math.sqrt(R / 2.0)
    return 2.943_275 * (1.25 * 0.5 * MASS / stiffness) ** 0.4


def pairs(dt, phases):
    """Position and velocity (x, y) of every sphere; the spheres of a pair touch within the second step, with centres along x."""
    for phase in range(phases):
        wait = dt * (1.0 + (phase + 0.5) / phases)
        for side in (-1.0, 1.0):
            yield (side * (R + 0.5 * wait), APART * (phase + 0.5) + side * 0.5 * wait), (-0.5 * side, -0.5 * side)


def run(command, folder):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{command}\n{done.stdout[-800:]}{done.stderr[-800:]}")


def lammps(args, folder, law, e, dt, steps, phases):
    """Velocity (x, y) and spin z of every sphere after the impact."""
    grains = list(enumerate(pairs(dt, phases), 1))
    with open(folder / "pairs.data", "w") as out:
        height = APART * phases
        out.write(f"pairs\n\n{2 * phases} atoms\n1 atom types\n-1 1 xlo xhi\n-0.2 {height + 0.2:.17g} ylo yhi\n-0.5 0.5 zlo zhi\n\nAtoms # sphere\n\n")
        density = MASS / (4.0 / 3.0 * math.pi * R**3)
        out.writelines(f"{i} 1 {2 * R:.17g} {density:.17g} {x:.17g} {y:.17g} 0\n" for i, ((x, y), _) in grains)
        out.write("\nVelocities\n\n")
        out.writelines(f"{i} {vx:.17g} {vy:.17g} 0 0 0 0\n" for i, (_, (vx, vy)) in grains)
    g = gamma(e)[0]
    style = {
        LAWS[0]: f"pair_style gran/hooke {K!r} 0 {g!r} 0 0 0\npair_coeff * *",
        LAWS[1]: f"pair_style gran/hooke/history {K!r} {K * 2 / 7!r} {g!r} {g / 2!r} {MU} 1\npair_coeff * *",
        LAWS[2]: f"pair_style granular\npair_coeff * * hertz/material {YOUNG!r} {e} {POISSON} tangential mindlin/force NULL 1.0 {MU} damping tsuji",
    }[law]
    (folder / "impact.in").write_text(
        f"units si\nboundary f f f\natom_style sphere\nnewton off\ncomm_modify vel yes\nread_data pairs.data\n{style}\n"
        "neighbor 0.02 bin\nneigh_modify every 1 delay 0 check yes\nfix move all nve/sphere\n"
        f"timestep {dt!r}\nrun {steps}\nwrite_dump all custom final.dump id vx vy omegaz modify sort id format float %.17g\n")
    run([args.lmp, "-in", "impact.in", "-log", "none"], folder)
    rows = (folder / "final.dump").read_text().splitlines()[9:]
    return [[float(word) for word in row.split()[1:]] for row in rows]


def siloflow(args, folder, law, e, dt, steps, phases):
    """The same, from siloflow."""
    with open(folder / "pairs.csv", "w") as out:
        out.write("id,radius,mass,x,y,vx,vy,z,vz\n")
        out.writelines(f"{i},{R},{MASS},{x:.17g},{y:.17g},{vx:.17g},{vy:.17g},0,0\n"
                       for i, ((x, y), (vx, vy)) in enumerate(pairs(dt, phases), 1))
    g = gamma(e)[0]
    linear = f"contact: Linear(k: {K!r}, damping: PerMass({g!r}), attraction: Allowed"
    contact = {
        LAWS[0]: f"{linear}),",
        LAWS[1]: f"{linear}, tangential: Spring(k: {K * 2 / 7!r}, damping: PerMass({g / 2!r}), friction: {MU})),",
        LAWS[2]: f"contact: Hertz(restitution: {e}, attraction: Allowed, tangential: Mindlin(friction: {MU})), "
                 f"materials: [(young: {YOUNG!r}, poisson: {POISSON})],",
    }[law]
    # Half a step short of the end: the step that reaches it is the last.
    (folder / "impact.ron").write_text(
        f'(space: Solid, gravity: (0.0, 0.0, 0.0), {contact} grains: (file: "pairs.csv"), integrator: Centred, step: Fixed({dt:.17f}), '
        f"until: {(steps - 0.5) * dt:.17f}, pictures: None)")
    run([args.siloflow, "run", "impact.ron", "--force", "--out", "out", "--quiet"], folder)
    with open(folder / "out" / "state.csv", newline="") as text:
        rows = sorted(csv.DictReader(line for line in text if line[0] != "#"), key=lambda row: int(row["id"]))
    return [[float(row["vx"]), float(row["vy"]), float(row.get("wz", 0.0))] for row in rows]


def after(args, program, law, e, n, phases=PHASES):
    """Relative velocity (x, y) and R times the sum of spins of every pair after the impact with n steps in a contact."""
    simulate = {"LAMMPS": lammps, "Centred": siloflow}[program]
    # Time enough to part even where a coarse step makes the contact last longer.
    dt, steps = duration(law, e) / n, math.ceil(2.5 * n) + 10
    with tempfile.TemporaryDirectory() as folder:
        rows = simulate(args, pathlib.Path(folder), law, e, dt, steps, phases)
    return [(b[0] - a[0], b[1] - a[1], R * (a[2] + b[2])) for a, b in zip(rows[::2], rows[1::2], strict=True)]


def limit(args, program, law, e):
    """The limit of fine steps, extrapolated from two of them."""
    n, order = FINE[program]
    coarse, fine = (after(args, program, law, e, m, 1)[0] for m in (n, 2 * n))
    return [b + (b - a) / (2**order - 1) for a, b in zip(coarse, fine, strict=True)]


def errors(args, program, law, e, exact):
    """(n, rms error) for every step."""
    found = []
    for n in STEPS[program]:
        n += math.pi / 8.0
        squares = [sum((x - y) ** 2 for x, y in zip(pair, exact, strict=True)) for pair in after(args, program, law, e, n)]
        found.append((n, math.sqrt(sum(squares) / len(squares)) / SPEED))
    return found


def steps_for(wanted, found):
    """The steps in a contact beyond which the error stays below what is wanted; the coarsest that was run if it suffices."""
    if found[-1][1] > wanted:
        return math.nan
    for (n, error), (finer, smaller) in reversed(list(zip(found, found[1:]))):
        if error >= wanted > smaller:
            return n * (finer / n) ** (math.log(error / wanted) / math.log(error / smaller))
    return found[0][0]


def nanoseconds(args, bed):
    """ns per particle-step of LAMMPS and of siloflow with `Centred` and the energy balance, medians of alternating runs."""
    command = [sys.executable, HERE / "side-by-side.py", "compare", bed, "--integrator", "Centred", "--rounds", args.rounds, "--lmp", args.lmp,
               "--siloflow", args.siloflow, "--dir", args.dir, "--core", args.core]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stdout + done.stderr)
    print(done.stdout, end="", flush=True)
    return [float(re.search(rf"^{name} +(\S+) ns", done.stdout, re.M)[1]) for name in ("LAMMPS", "siloflow")]


def measure(args):
    steps = {}
    for law in LAWS:
        for e in (0.9, 0.5, 0.2):
            limits = {program: limit(args, program, law, e) for program in STEPS}
            apart = math.dist(*limits.values()) / SPEED
            print(f"{law}, e = {e}: the limits of fine steps differ by {apart:.1e} of the speed", flush=True)
            for program, exact in limits.items():
                found = errors(args, program, law, e, exact)
                for wanted in WANTED:
                    steps[law, e, wanted, program] = steps_for(wanted, found)
    return steps


def table(steps, ns):
    rows = []
    for law, e, wanted in dict.fromkeys(key[:3] for key in steps):
        theirs, ours = (steps[law, e, wanted, program] for program in STEPS)
        ratios = [theirs * lmp / (ours * own) for lmp, own in ns]
        rows.append([law, e, wanted, f"{theirs:.4g}", f"{ours:.4g}", *(f"{x:.1f}" for pair in ns for x in pair), *(f"{x:.3g}" for x in ratios)])
    return rows


def means(rows):
    """Geometric means of the ratios over the cases, for each error and bed."""
    for wanted in WANTED:
        own = [row for row in rows if float(row[2]) == wanted]
        yield wanted, [math.exp(sum(math.log(float(row[column])) for row in own) / len(own)) for column in (-2, -1)]


def draw(rows):
    """Bars of the ratio of times in W1, case by case; a line marks W2."""
    width, left, top, bar, gap = 820, 190, 66, 13, 12
    colours = {1.0e-2: "#9ecae1", 1.0e-3: "#0072b2", 1.0e-4: "#08306b"}
    cases = list(dict.fromkeys((row[0], row[1]) for row in rows))
    height = top + len(cases) * (len(WANTED) * bar + gap) + 46
    most = max(float(row[-2]) for row in rows)
    x = lambda ratio: left + (width - left - 60) * math.log10(max(ratio, 1.0)) / math.log10(1.2 * most)
    bottom = height - 42
    svg = [f'<rect width="{width}" height="{height}" fill="white"/>',
           '<text x="20" y="24" font-size="15">Time of LAMMPS over that of siloflow (Centred) for the same rms error of an oblique impact</text>']
    for number, wanted in enumerate(WANTED):
        svg += [f'<rect x="{20 + 130 * number}" y="36" width="12" height="12" fill="{colours[wanted]}"/>',
                f'<text x="{38 + 130 * number}" y="47">error {wanted:g}</text>']
    svg.append('<text x="410" y="47">bars: bed W1; white lines: bed W2</text>')
    for value in (1, 2, 5, 10, 20, 50, 100, 200, 500):
        if value < 1.2 * most:
            svg += [f'<line x1="{x(value):.1f}" y1="{top}" x2="{x(value):.1f}" y2="{bottom}" stroke="#ddd"/>',
                    f'<text x="{x(value):.1f}" y="{bottom + 18}" text-anchor="middle">{value}</text>']
    y = top + gap / 2
    for law, e in cases:
        svg.append(f'<text x="{left - 10}" y="{y + 1.5 * bar + 4:.1f}" text-anchor="end">{law}, e = {e}</text>')
        for row in (row for row in rows if (row[0], row[1]) == (law, e)):
            w1, w2 = float(row[-2]), float(row[-1])
            svg += [f'<rect x="{left}" y="{y}" width="{x(w1) - left:.1f}" height="{bar - 2}" fill="{colours[float(row[2])]}"/>',
                    f'<rect x="{x(w2) - 1:.1f}" y="{y}" width="2" height="{bar - 2}" fill="white"/>',
                    f'<text x="{x(w1) + 5:.1f}" y="{y + 10}" font-size="11">{w1:.3g}</text>']
            y += bar
        y += gap
    FIGURE.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
        'font-family="Ubuntu, sans-serif" font-size="13">\n' + "\n".join(svg) + "\n</svg>\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--lmp", default="lmp")
    parser.add_argument("--siloflow", type=pathlib.Path, default=pathlib.Path("target/release/siloflow"))
    parser.add_argument("--dir", type=pathlib.Path, default=pathlib.Path("target/side-by-side"), help="of side-by-side.py")
    parser.add_argument("--csv", type=pathlib.Path, default=HERE / "time-to-error.csv")
    parser.add_argument("--core", default="0")
    parser.add_argument("--rounds", default="5")
    parser.add_argument("--ns", type=pathlib.Path, help="a table of an earlier sitting, whose nanoseconds are used")
    parser.add_argument("--steps", type=pathlib.Path, help="a table whose steps are used: only times are measured")
    args = parser.parse_args()
    args.siloflow = args.siloflow.resolve()
    if args.ns:
        with args.ns.open() as file:
            row = next(csv.DictReader(file))
        ns = [[float(row[f"ns_{bed}_{program}"]) for program in ("lammps", "centred")] for bed in ("w1", "w2")]
    else:
        ns = [nanoseconds(args, bed) for bed in ("w1-1e4", "w2-1e4")]
    if args.steps:
        with args.steps.open() as file:
            steps = {(row["law"], float(row["restitution"]), float(row["error"]), program): float(row[f"steps_{program.lower()}"])
                     for row in csv.DictReader(file) for program in STEPS}
    else:
        steps = measure(args)
    rows = table(steps, ns)
    with args.csv.open("w", newline="") as out:
        csv.writer(out, lineterminator="\n").writerows([COLUMNS, *rows])
    print("| law | e | error | steps in a contact, LAMMPS | `Centred` | time ratio, W1 | W2 |\n|---|---|---|---|---|---|---|")
    for law, e, wanted, theirs, ours, *_, w1, w2 in rows:
        print(f"| {law} | {e} | {wanted:g} | {theirs} | {ours} | {w1} | {w2} |")
    for wanted, (w1, w2) in means(rows):
        print(f"| geometric mean | | {wanted:g} | | | {w1:.3g} | {w2:.3g} |")
    draw(rows)


if __name__ == "__main__":
    main()
