#!/usr/bin/env python3
"""Draws the bar chart of the comparison with LAMMPS from docs/speed/side-by-side.csv.

    docs/speed/bar-chart.py                             (writes docs/figures/side-by-side.svg)
    siloflow render docs/figures/side-by-side.svg       (writes docs/figures/side-by-side.png)

The table holds nanoseconds per particle-step as docs/speed/side-by-side.py prints them. No packages needed.
"""

import csv
import pathlib

HERE = pathlib.Path(__file__).resolve().parent
OUT = HERE.parent / "figures/side-by-side.svg"
BARS = (
    ("lammps_debian_ns", "LAMMPS, Debian's package", "#bdbdbd"),
    ("lammps_native_ns", "LAMMPS, compiled for the machine", "#8a8a8a"),
    ("centred_ns", "siloflow, Centred (the default)", "#0072b2"),
    ("verlet_ns", "siloflow, Verlet (the scheme of LAMMPS)", "#7fb8d9"),
)
# Room for the label of the longest bar is left at the right.
WIDTH, LEFT, RIGHT, TOP, BAR, GAP, TICK = 820, 230, 50, 74, 17, 18, 20


def main():
    with (HERE / "side-by-side.csv").open() as file:
        beds = list(csv.DictReader(file))
    most = max(float(bed[key]) for bed in beds for key, *_ in BARS)
    scale = (WIDTH - LEFT - RIGHT) / most
    height = TOP + len(beds) * (len(BARS) * BAR + GAP) + 46
    bottom = height - 46
    svg = [f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
           '<text x="20" y="24" font-size="15">Time per particle-step beside LAMMPS, one core of an AMD EPYC (Turin)</text>']
    for number, (_, name, colour) in enumerate(BARS):
        x, y = 20 + 400 * (number % 2), 34 + 18 * (number // 2)
        svg += [f'<rect x="{x}" y="{y}" width="12" height="12" fill="{colour}"/>', f'<text x="{x + 18}" y="{y + 11}">{name}</text>']
    for value in range(0, int(most) + 1, TICK):
        x = LEFT + scale * value
        svg += [f'<line x1="{x}" y1="{TOP}" x2="{x}" y2="{bottom}" stroke="#ddd"/>',
                f'<text x="{x}" y="{bottom + 18}" text-anchor="middle">{value}</text>']
    svg.append(f'<text x="{LEFT + scale * most / 2}" y="{bottom + 38}" text-anchor="middle">ns per particle-step</text>')
    y = TOP + GAP / 2
    for bed in beds:
        middle = y + len(BARS) * BAR / 2
        svg += [f'<text x="{LEFT - 10}" y="{middle - 3}" text-anchor="end">{bed["label"]}</text>',
                f'<text x="{LEFT - 10}" y="{middle + 13}" text-anchor="end">{int(bed["grains"]):,} grains</text>']
        for key, _, colour in BARS:
            value = float(bed[key])
            svg += [f'<rect x="{LEFT}" y="{y}" width="{scale * value:.1f}" height="{BAR - 2}" fill="{colour}"/>',
                    f'<text x="{LEFT + scale * value + 5:.1f}" y="{y + 12}">{value:g}</text>']
            y += BAR
        y += GAP
    OUT.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" viewBox="0 0 {WIDTH} {height}" '
        'font-family="Ubuntu, sans-serif" font-size="13">\n' + "\n".join(svg) + "\n</svg>\n")


if __name__ == "__main__":
    main()
