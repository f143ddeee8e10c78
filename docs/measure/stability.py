#!/usr/bin/env python3
"""The coarsest step at which a settled bed stays calm, for each scheme, beside the limit that `siloflow check` prints.

    cargo build --release
    docs/measure/stability.py [--siloflow target/release/siloflow]     (writes docs/measure/stability.csv; three minutes)

Two beds of about 1000 grains settle without friction on a floor between periodic sides: discs (R = 0.03 and 0.04 m, m = 100 R^2
kg/m^2) and spheres (R = 0.03 to 0.04 m, 500 kg/m^3), k = 1e5 N/m. Each grain then gets a random velocity of 1e-3 sqrt(g R), and
the bed runs 5000 steps with the law and the scheme of the row. Friction: mu = 0.5, k_t = 2/7 k, c_t = c/2. The law "Assignment" has
the drag b that gives a head-on impact the restitution e.

A bed is agitated if its kinetic energy at the end exceeds twice the energy of the start, or if the run fails or is refused. The step is
halved in its interval (logarithms) until the calm and the agitated step differ by 2 %. Printed are both limits as steps in the
shortest contact, t_c/dt, and the calm step over that printed by `check`. The exit status is 1 if a bed is agitated at 0.99 of the
printed limit.
"""

import argparse
import csv
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
K, G, R, STEPS = 1.0e5, 9.81, 0.03, 5000  # N/m, m/s^2, m
RESTITUTIONS = (0.9, 0.75, 0.5, 0.2)
SCHEMES = ("Verlet", "Centred")
BEDS = {
    "discs": 'periodic: (x: (0.0, 2.08)), walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], gravity: (0.0, -9.81)',
    "spheres": 'space: Solid, periodic: (x: (0.0, 0.8), y: (0.0, 0.8)), gravity: (0.0, 0.0, -9.81), '
               'walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))]',
}
FILLS = {
    "discs": "mass: ArealSquare(100.0), fill: [(low: (0.0, 0.0), high: (2.08, 3.2), spacing: 0.081, "
             "radius: Mixture([(0.03, 0.5), (0.04, 0.5)]), agitation: (0.3, 0.3))]",
    "spheres": "mass: Sphere(500.0), fill: [(low: (0.0, 0.0, 0.0), high: (0.8, 0.8, 0.9), spacing: 0.0801, "
               "radius: Uniform(0.03, 0.04), agitation: (0.3, 0.3, 0.3))]",
}
COLUMNS = ("bed", "law", "friction", "restitution", "scheme", "contact_s", "printed_s", "calm_s", "agitated_s")


def law(kind, e, friction):
    """The scene's contact. The drag of the assignment's law is that of two of the smallest discs, e = exp(-pi zeta/sqrt(1 - zeta^2))."""
    if kind == "Assignment":
        zeta = -math.log(e) / math.hypot(math.pi, math.log(e))
        mass = 0.5 * 100.0 * R * R
        return f"Assignment(k: {K}, b: {2.0 * zeta * math.sqrt(K * mass)!r})"
    term = f", tangential: Spring(k: {K * 2 / 7!r}, damping: OfNormal(0.5), friction: {friction})" if friction else ""
    return f"Linear(k: {K}, damping: Restitution({e}){term})"


def siloflow(args, *words):
    return subprocess.run([args.siloflow, *map(str, words)], capture_output=True, text=True, check=False)


def settle(args, bed, folder):
    """Lets a bed come to rest; returns its grains with random velocities, as text, and their kinetic energy, J."""
    scene = folder / f"settle-{bed}.ron"
    scene.write_text(f"({BEDS[bed]}, {FILLS[bed]}, contact: {law('Linear', 0.2, 0)}, integrator: Verlet, step: Fixed(1.0e-4), "
                     f"until: 6.0, pictures: None, energy_balance: false, series: (interval: 10.0))")
    done = siloflow(args, "run", scene, "--out", folder / bed, "--quiet")
    if done.returncode:
        sys.exit(done.stdout + done.stderr)
    with (folder / bed / "state.csv").open() as file:
        rows = list(csv.DictReader(file))
    draw, energy = random.Random(1), 0.0
    for row in rows:
        size = 1.0e-3 * math.sqrt(G * R)
        for axis in ("vx", "vy", "vz"):
            if axis in row:
                row[axis] = draw.gauss(0.0, size)
                energy += 0.5 * float(row["mass"]) * row[axis] ** 2
    columns = [column for column in rows[0] if column != "species" and not column.startswith("w")]
    lines = [",".join(columns)] + [",".join(str(row[column]) for column in columns) for row in rows]
    return "\n".join(lines) + "\n", energy


class Row:
    """One bed with one law and one scheme."""

    def __init__(self, args, folder, bed, kind, friction, e, scheme, energy):
        self.args, self.folder, self.energy = args, folder, energy
        self.scene = folder / f"{bed}-grains.ron"
        self.scene.write_text(f'({BEDS[bed]}, grains: (file: "{bed}.csv"), contact: {law(kind, e, friction)}, integrator: {scheme}, '
                              "step: Fixed(1.0e-6), until: 1.0, pictures: None, energy_balance: false, series: (interval: 10.0))")
        # `check` prints the limit of a dense bed in any case.
        text = siloflow(args, "check", self.scene).stdout
        self.contact = float(re.search(r"contact +(\S+) s long", text)[1])
        self.printed = float(re.search(r"(\S+) s in a dense bed", text)[1])

    def is_calm(self, dt):
        done = siloflow(self.args, "run", self.scene, "--force", "--out", self.folder / "out", "--quiet",
                        "--set", f"step=Fixed({dt!r})", "--until", repr((STEPS - 0.5) * dt))
        if done.returncode:
            return False
        with (self.folder / "out" / "series.csv").open() as file:
            last = list(csv.DictReader(file))[-1]
        return float(last["kinetic_j"]) + float(last["rotational_j"]) < 2.0 * self.energy

    def limit(self):
        """Returns the coarsest calm step and the finest agitated one that were found, s."""
        low, high = self.contact / 40.0, self.contact / 2.0
        if not self.is_calm(low):
            return math.nan, low
        while high > 1.02 * low:
            middle = math.sqrt(low * high)
            if self.is_calm(middle):
                low = middle
            else:
                high = middle
        return low, high


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--siloflow", type=pathlib.Path, default=pathlib.Path("target/release/siloflow"))
    parser.add_argument("--csv", type=pathlib.Path, default=HERE / "stability.csv")
    args = parser.parse_args()
    args.siloflow = args.siloflow.resolve()
    kinds = [("discs", "Linear", 0), ("discs", "Linear", 0.5), ("discs", "Assignment", 0), ("spheres", "Linear", 0), ("spheres", "Linear", 0.5)]
    agitated = False
    with tempfile.TemporaryDirectory() as folder, args.csv.open("w", newline="") as out:
        folder = pathlib.Path(folder)
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(COLUMNS)
        energies = {}
        for bed in BEDS:
            text, energies[bed] = settle(args, bed, folder)
            (folder / f"{bed}.csv").write_text(text)
        for bed, kind, friction in kinds:
            for e in RESTITUTIONS:
                for scheme in SCHEMES:
                    row = Row(args, folder, bed, kind, friction, e, scheme, energies[bed])
                    calm, rough = row.limit()
                    below = row.is_calm(0.99 * row.printed)
                    agitated |= not below
                    writer.writerow([bed, kind, friction, e, scheme, *(f"{x:.4e}" for x in (row.contact, row.printed, calm, rough))])
                    out.flush()
                    print(f"{bed:8}{kind:11} mu {friction:<4} e {e:<5}{scheme:8} t_c/dt: printed {row.contact / row.printed:6.2f}, "
                          f"calm {row.contact / calm:6.2f}, calm/printed {calm / row.printed:5.2f}"
                          f"{'' if below else ', agitated at 0.99 of the printed limit'}", flush=True)
    sys.exit(1 if agitated else 0)


if __name__ == "__main__":
    main()
