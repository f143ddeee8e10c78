#!/usr/bin/env python3
"""Pair distances and instructions per step of the neighbour searches, on beds at rest: a table and a figure.

    cargo build --release
    docs/measure/searches.py [--siloflow target/release/siloflow]    (writes searches.csv, docs/figures/searches.svg; 5 minutes)
    docs/measure/searches.py --draw                                  (draws the figure from searches.csv)
    siloflow render docs/figures/searches.svg                        (writes docs/figures/searches.png)

Unlike times (docs/measure/searches.sh), both numbers do not depend on the load of the machine.

The beds: N grains of R = 0.028 m that have come to rest in the silo of scenes/silo1.ron. Two series: N at L = 0.25 m, and
the cell size L at N = 1000.

Distances are counted here from the positions of the grains, each pair once, pairs of two wall grains left out: all pairs;
pairs in the same cell or in neighbouring cells; pairs closer than R_i + R_j + skin (the pairs that the Verlet list keeps for
a bed at rest). Instructions are those of 200 whole steps, counted by valgrind: a run of 250 steps less a run of 50 steps, so
that start-up is left out. valgrind knows no AVX-512, so the program uses AVX2.

Every failed run stops the script.
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
ROOT = HERE.parent.parent
RADIUS, SKIN, SIZE, DT = 0.028, 0.04, 0.25, 1.0e-3  # m, m, m, s
COUNTS = (250, 500, 1000, 2000)
SIZES = (0.06, 0.08, 0.12, 0.25, 0.5, 1.0)  # m
FEW, MANY = 50, 250  # steps
COLUMNS = ("grains", "search", "size_m", "distances", "instructions")


def sh(*command):
    done = subprocess.run([str(word) for word in command], cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"searches.py: exit status {done.returncode} of {' '.join(map(str, command))}\n{done.stdout[-1000:]}{done.stderr[-1000:]}")
    return done.stderr


def make_bed(options, folder, count):
    out = folder / f"bed{count}"
    sh(options.siloflow, "run", "scenes/silo1.ron", "--quiet", "--force", "--out", out, "--set", f"spawner.count={count}",
       "--set", f"spawner.radius=Fixed({RADIUS})", "--set", "spawner.interval=0.04", "--set", "rest.stop=true",
       "--set", "pictures=None")
    return out / "state.csv"


def particles(bed):
    """(x, y, radius, is fixed) of grains, wall and door, m."""
    with bed.open() as file:
        found = [(float(row["x"]), float(row["y"]), float(row["radius"]), False) for row in csv.DictReader(file)]
    lines = (ROOT / "assets/silo1.dat").read_text().split("\n")[1:]
    wall = [[0.01 * float(word) for word in line.split()] for line in lines if line.strip()]
    return found + [(x, y, radius, True) for x, y, radius in wall]


def distances(bed, name, size):
    """Pair distances per step."""
    all_of_them = particles(bed)
    if name == "all pairs":
        moving = sum(not fixed for *_, fixed in all_of_them)
        return moving * (moving - 1) // 2 + moving * (len(all_of_them) - moving)
    side = size if name == "cells" else 2.0 * RADIUS + 0.01 + SKIN
    cells = {}
    for number, (x, y, *_) in enumerate(all_of_them):
        cells.setdefault((math.floor(x / side), math.floor(y / side)), []).append(number)
    count = 0
    for (column, row), members in cells.items():
        near = [j for a in (-1, 0, 1) for b in (-1, 0, 1) for j in cells.get((column + a, row + b), ())]
        for i in members:
            x, y, radius, fixed = all_of_them[i]
            for j in near:
                other = all_of_them[j]
                if j <= i or (fixed and other[3]):
                    continue
                count += name == "cells" or math.hypot(x - other[0], y - other[1]) < radius + other[2] + SKIN
    return count


def instructions(options, folder, bed, search):
    """Of one whole step."""
    totals = []
    for steps in (FEW, MANY):
        said = sh("valgrind", "--tool=callgrind", f"--callgrind-out-file={folder / 'counts'}", options.siloflow, "run",
                  "scenes/silo1.ron", "--quiet", "--force", "--out", folder / "run", "--set", "spawner.count=0", "--set", "pictures=None",
                  "--set", "rest=None", "--set", "bed=None", "--set", "door=None", "--set", f'grains=(file: "{bed}")',
                  "--set", f"neighbours={search}", "--set", "series=(interval: 1.0e3)", "--until", repr(steps * DT))
        totals.append(int(re.search(r"Collected : (\d+)", said)[1]))
    return (totals[1] - totals[0]) / (MANY - FEW)


def measure(options):
    cases = [(count, *search) for count in COUNTS for search in (("all pairs", ""), ("cells", SIZE), ("list", ""))]
    cases += [(1000, "cells", size) for size in SIZES if size != SIZE]
    words = {"all pairs": "AllPairs", "list": f"VerletList(skin: {SKIN})"}
    with tempfile.TemporaryDirectory() as folder, options.csv.open("w", newline="") as file:
        folder, beds = pathlib.Path(folder), {}
        out = csv.writer(file, lineterminator="\n")
        out.writerow(COLUMNS)
        for count, name, size in cases:
            bed = beds[count] = beds.get(count) or make_bed(options, folder, count)
            search = words.get(name, f"Cells(size: {size})")
            row = (count, name, size, distances(bed, name, size), round(instructions(options, folder, bed, search)))
            out.writerow(row)
            file.flush()
            print(*row, flush=True)


def table(path):
    with path.open() as file:
        rows = list(csv.DictReader(file))
    return {(int(row["grains"]), row["search"], row["size_m"]): (int(row["distances"]), int(row["instructions"])) for row in rows}


def panel(left, title, unit, x_ticks, y_ticks, lines):
    """One panel with two logarithmic axes: `lines` are (name, colour, dash, points)."""
    width, height, top = 330.0, 300.0, 50.0
    low, high = math.log10(x_ticks[0]) - 0.06, math.log10(x_ticks[-1]) + 0.06
    bottom, upper = math.log10(y_ticks[0]), math.log10(y_ticks[-1])

    def at(x, y):
        return (left + width * (math.log10(x) - low) / (high - low), top + height * (upper - math.log10(y)) / (upper - bottom))

    svg = [f'<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#888"/>',
           f'<text x="{left + width / 2}" y="{top - 14}" text-anchor="middle">{title}</text>',
           f'<text x="{left + width / 2}" y="{top + height + 40}" text-anchor="middle">{unit}</text>']
    for tick in x_ticks:
        x, y = at(tick, y_ticks[0])
        svg += [f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{x:.1f}" y2="{y + 5:.1f}" stroke="#888"/>',
                f'<text x="{x:.1f}" y="{y + 20:.1f}" text-anchor="middle">{tick:g}</text>']
    for tick in y_ticks:
        y = at(x_ticks[0], tick)[1]
        svg += [f'<line x1="{left}" y1="{y:.1f}" x2="{left + width}" y2="{y:.1f}" stroke="#ddd"/>',
                f'<text x="{left - 8}" y="{y + 5:.1f}" text-anchor="end">{tick:g}</text>']
    for name, colour, dash, points, where in lines:
        path = " ".join("{:.1f},{:.1f}".format(*at(*point)) for point in points)
        svg.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2" stroke-dasharray="{dash}"/>')
        svg += ['<circle cx="{:.1f}" cy="{:.1f}" r="4" fill="{}"/>'.format(*at(*point), colour) for point in points]
        x, y = at(*points[where])
        svg.append(f'<text x="{x - 6:.1f}" y="{y - 10:.1f}" text-anchor="{"end" if where else "start"}" fill="{colour}">{name}</text>')
    return svg


def draw(options):
    found = table(options.csv)
    counts = sorted({grains for grains, *_ in found})
    sizes = sorted(float(size) for grains, name, size in found if name == "cells" and grains == 1000)

    def gain(grains, name, size, which):
        return found[grains, "all pairs", ""][which] / found[grains, name, size][which]

    def both(colour, text, xs, keys, where):
        return [(f"{text}, {quantity}", colour, dash, [(x, gain(*key, which)) for x, key in zip(xs, keys)], where)
                for which, quantity, dash in ((0, "distances", "6 4"), (1, "instructions", ""))]

    by_count = both("#0072b2", "list", counts, [(n, "list", "") for n in counts], -1)
    by_count += both("#d55e00", "cells", counts, [(n, "cells", "0.25") for n in counts], -1)
    by_size = both("#d55e00", "cells", sizes, [(1000, "cells", str(size)) for size in sizes], 0)
    svg = panel(70, "L = 0.25 m", "number of grains", counts, (1, 10, 100, 1000), by_count)
    svg += panel(480, "N = 1000", "cell size L, m", sizes, (0.1, 1, 10, 100, 1000), by_size)
    options.svg.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="840" height="440" viewBox="0 0 840 440" font-family="Ubuntu, sans-serif" '
        'font-size="13">\n<rect width="840" height="440" fill="white"/>\n'
        '<text x="420" y="18" text-anchor="middle">Speed-up over all pairs: pair distances and instructions per step</text>\n'
        + "\n".join(svg) + "\n</svg>\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--siloflow", type=pathlib.Path, default=ROOT / "target/release/siloflow")
    parser.add_argument("--csv", type=pathlib.Path, default=HERE / "searches.csv")
    parser.add_argument("--svg", type=pathlib.Path, default=ROOT / "docs/figures/searches.svg")
    parser.add_argument("--draw", action="store_true", help="draw only")
    options = parser.parse_args()
    options.siloflow = options.siloflow.resolve()
    if not options.draw:
        measure(options)
    draw(options)


if __name__ == "__main__":
    main()
