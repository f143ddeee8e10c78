#!/usr/bin/env python3
"""The beds of uniform grains and of the mixture at rest, side by side, with their crystal faults, as an SVG.

    siloflow run scenes/silo1.ron --set rest.stop=true --set pictures=None --out /tmp/uniform
    siloflow run scenes/silo1-mixture.ron --set rest.stop=true --set pictures=None --out /tmp/mixture
    docs/measure/faults.py /tmp/uniform /tmp/mixture        (writes docs/figures/silo1-faults.svg, prints shares)
    siloflow render docs/figures/silo1-faults.svg           (writes docs/figures/silo1-faults.png)

A neighbour of a grain is a grain whose centre is closer than 1.3 (R_i + R_j). In a close-packed crystal of equal discs each
grain has six neighbours, and the next shell of grains is at 1.73 (R_i + R_j). Blue: six neighbours. Orange: another number.
Grey: grains at a wall or at the surface, which cannot have six.
"""

import argparse
import csv
import math
import pathlib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
NEAR, SCALE = 1.3, 130.0  # of R_i + R_j; px/m
HIGH = 3.4  # m, top of the picture


def read(folder):
    with (folder / "state.csv").open() as file:
        return [(float(row["x"]), float(row["y"]), float(row["radius"])) for row in csv.DictReader(file)]


def walls():
    lines = (ROOT / "assets/silo1.dat").read_text().split("\n")
    fixed = int(lines[0].split()[0])
    rows = [[0.01 * float(word) for word in line.split()] for line in lines[1:] if line.strip()]
    return [(x, y, radius, number >= fixed) for number, (x, y, radius) in enumerate(rows)]


def colours(grains, fixed):
    for i, (x, y, radius) in enumerate(grains):
        near, angles = 0, []
        for j, (a, b, other) in enumerate(grains):
            if j != i and math.hypot(a - x, b - y) < NEAR * (radius + other):
                near += 1
                angles.append(math.atan2(b - y, a - x))
        angles.sort()
        gaps = [after - before for before, after in zip(angles, angles[1:] + [angles[0] + 2 * math.pi])] if angles else [7.0]
        at_wall = any(math.hypot(a - x, b - y) < NEAR * (radius + other) for a, b, other, _ in fixed)
        # At the surface more than 150 degrees around the grain are empty.
        edge = at_wall or max(gaps) > math.radians(150)
        yield "#b0b0b0" if edge else "#3f86c6" if near == 6 else "#e69f00"


def bed(grains, fixed, left, title):
    found = list(colours(grains, fixed))
    inner = [colour for colour in found if colour != "#b0b0b0"]
    share = inner.count("#e69f00") / len(inner)
    print(f"{title}: {len(inner)} grains inside the bed, {100 * share:.0f} % without six neighbours")

    def disc(x, y, radius, colour):
        return f'<circle cx="{left + SCALE * x:.1f}" cy="{40 + SCALE * (HIGH - y):.1f}" r="{SCALE * radius:.1f}" fill="{colour}"/>'

    svg = [f'<text x="{left}" y="24" text-anchor="middle">{title}: {100 * share:.0f} % without six neighbours</text>']
    svg += [disc(x, y, radius, "#2e9e3f" if door else "#c0392b") for x, y, radius, door in fixed if y < HIGH]
    return svg + [disc(x, y, radius, colour) for (x, y, radius), colour in zip(grains, found)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("uniform", type=pathlib.Path, help="run directory")
    parser.add_argument("mixture", type=pathlib.Path, help="run directory")
    parser.add_argument("--svg", type=pathlib.Path, default=ROOT / "docs/figures/silo1-faults.svg")
    options = parser.parse_args()
    fixed = walls()
    svg = bed(read(options.uniform), fixed, 190, "uniform, 4 cm") + bed(read(options.mixture), fixed, 570, "half 4 cm, half 3 cm")
    options.svg.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="760" height="500" viewBox="0 0 760 500" font-family="Ubuntu, sans-serif" '
        'font-size="15">\n<rect width="760" height="500" fill="white"/>\n' + "\n".join(svg) + "\n</svg>\n")


if __name__ == "__main__":
    main()
