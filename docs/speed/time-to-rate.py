#!/usr/bin/env python3
"""Cost and error of a discharge rate: scheme, step, stiffness and number of grains, siloflow beside LAMMPS, in one table and one figure.

    apt-get install --no-install-recommends lammps
    cargo build --release
    docs/speed/time-to-rate.py                       (writes time-to-rate.csv beside it, docs/figures/time-to-rate.svg)
    siloflow render docs/figures/time-to-rate.svg    (writes docs/figures/time-to-rate.png)

The silo is that of Dosta et al. 2024 with the large orifice and M1 (scenes/validation/dosta-silo/silo.ron). Each run fills, waits for rest, opens the orifice and
discharges, on one core. The rate is the slope of the grains out from 0.1 to 0.4 s after the opening, read from `series.csv` of both programs in the same way; 20,000 grains
run dry earlier, and their rate is from 0.1 to 0.3 s. LAMMPS runs the script of `siloflow export`. The time is the wall-clock time of the whole run.

The error of a row is that of its mean rate over the seeds, against the mean of the stiffest rows (`soft` = 0.1). Its standard error comes from the scatter over
seeds, pooled over all rows. Runs that are in the table are not run again.
"""

import argparse
import csv
import json
import math
import os
import pathlib
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
FIGURE = ROOT / "docs/figures/time-to-rate.svg"
SCENE = ROOT / "scenes/validation/dosta-silo/silo.ron"
COLUMNS = ("program", "scheme", "soft", "step_s", "grains", "seed", "rate_per_s", "particle_steps", "wall_s")
# (program, scheme, share of the published Young's moduli, step in s, grains, seeds)
ROWS = (
    ("siloflow", "Verlet", 1e-3, 3.5e-5, 30_000, 3),
    ("siloflow", "Verlet", 1e-4, 9.4e-5, 30_000, 3),
    ("lammps", "Verlet", 1e-4, 9.4e-5, 30_000, 1),
    ("lammps", "Verlet", 1e-3, 3.5e-5, 30_000, 1),
    ("lammps", "Verlet", 1e-2, 1.3e-5, 30_000, 1),
    ("siloflow", "Verlet", 1e-2, 1.3e-5, 30_000, 3),
    ("siloflow", "Verlet", 1e-1, 4.74e-6, 30_000, 2),
    ("siloflow", "Verlet", 1e-2, 1.55e-5, 30_000, 1),
    ("siloflow", "Verlet", 3e-3, 2.2e-5, 30_000, 1),
    ("siloflow", "Centred", 1e-2, 1.3e-5, 30_000, 1),
    ("siloflow", "Verlet", 1e-2, 1.3e-5, 20_000, 1),
)
REFERENCE = 1e-1  # soft


def settings(scheme, soft, step, grains, seed):
    """The changes of the scene."""
    values = {"parameters.soft": soft, "parameters.dt": step, "parameters.grains": grains, "parameters.most": 12_000, "integrator": scheme, "seed": seed}
    return [word for key, value in values.items() for word in ("--set", f"{key}={value}")]


def rate(folder, grains):
    """Slope of the grains out after the opening, 1/s."""
    summary = json.loads((folder / "summary.json").read_text())
    opened = summary["door_open_time_s"]
    with open(folder / "series.csv", newline="") as text:
        rows = [(float(row["time_s"]) - opened, float(row["out"])) for row in csv.DictReader(line for line in text if line[0] != "#")]
    last = 0.4 if grains > 25_000 else 0.3
    points = [(t, n) for t, n in rows if 0.1 <= t <= last]
    middle = [sum(values) / len(points) for values in zip(*points)]
    return sum((t - middle[0]) * (n - middle[1]) for t, n in points) / sum((t - middle[0]) ** 2 for t, _ in points)


def run(command, folder, core):
    start = time.perf_counter()
    done = subprocess.run(["taskset", "-c", core, *map(str, command)], cwd=folder, capture_output=True, text=True, env=dict(os.environ, OMP_NUM_THREADS="1"))
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))} failed:\n{done.stdout[-1000:]}{done.stderr[-2000:]}")
    return time.perf_counter() - start


def measure(args, row, seed):
    program, scheme, soft, step, grains, _ = row
    folder = args.dir / f"{program}-{scheme}-{soft:g}-{step:g}-{grains}-{seed}"
    subprocess.run(["rm", "-rf", str(folder)], check=True)
    changes = settings(scheme, soft, step, grains, seed)
    if program == "siloflow":
        wall = run([args.siloflow, "run", SCENE, *changes, "--out", folder, "--quiet"], args.dir, args.core)
        steps = json.loads((folder / "summary.json").read_text())["performance"]["particle_steps"]
    else:
        run([args.siloflow, "export", SCENE, "--to", "lammps", *changes, "--out", folder, "--quiet"], args.dir, args.core)
        wall = run([args.lmp, "-in", "in.silo", "-screen", "none"], folder, args.core)
        steps = ""
    return [program, scheme, soft, step, grains, seed, round(rate(folder, grains), 1), steps, round(wall, 2)]


def means(rows):
    """Key of each row: mean rate, its standard error, mean time (s), number of seeds."""
    groups = {}
    for row in rows:
        groups.setdefault(tuple(row[:5]), []).append((float(row[6]), float(row[8])))
    spreads = [(len(runs) - 1, sum((r - sum(x for x, _ in runs) / len(runs)) ** 2 for r, _ in runs)) for runs in groups.values()]
    scatter = math.sqrt(sum(square for _, square in spreads) / max(1, sum(freedom for freedom, _ in spreads)))
    found = {}
    for key, runs in groups.items():
        mean = sum(r for r, _ in runs) / len(runs)
        found[key] = (mean, scatter / math.sqrt(len(runs)), sum(t for _, t in runs) / len(runs), len(runs))
    return found, scatter


def report(rows):
    found, scatter = means(rows)
    stiffest = [value for key, value in found.items() if float(key[2]) == REFERENCE]
    if not stiffest:
        sys.exit("no row of the reference")
    reference, own = stiffest[0][0], stiffest[0][1]
    print(f"reference {reference:.0f} +- {own:.0f} grains/s; scatter of a run {100 * scatter / reference:.2f} %")
    print("| program | scheme | E/E_published | step, s | grains | runs | rate, 1/s | error, % | time of a run, s |\n|---|---|---|---|---|---|---|---|---|")
    points = []
    for key, (mean, error, wall, count) in sorted(found.items(), key=lambda item: item[1][2]):
        program, scheme, soft, step, grains = key
        off = 100 * (mean / reference - 1)
        error = 100 * math.hypot(error, own if stiffest[0] != (mean, error, wall, count) else 0.0) / reference
        name = "LAMMPS" if program == "lammps" else program
        print(f"| {name} | {scheme} | {float(soft):g} | {float(step):g} | {int(grains):,} | {count} | {mean:.0f} | {off:+.2f} ± {error:.2f} | {wall:.0f} |")
        points.append((key, wall, off, error))
    return points


def draw(points):
    """Error against time; a bar is a standard error."""
    width, height, left, right, top, bottom = 820, 470, 70, 20, 64, 60
    times = [wall for _, wall, _, _ in points]
    low, high = 0.7 * min(times), 1.4 * max(times)
    least, most = math.floor(min(-2.0, *(off - error for _, _, off, error in points))), math.ceil(max(2.0, *(off + error for _, _, off, error in points)))
    x = lambda t: left + (width - left - right) * math.log10(t / low) / math.log10(high / low)
    y = lambda e: top + (height - top - bottom) * (most - e) / (most - least)
    colours = {("siloflow", "Verlet"): "#0072b2", ("siloflow", "Centred"): "#009e73", ("lammps", "Verlet"): "#d55e00"}
    names = {("siloflow", "Verlet"): "siloflow, Verlet", ("siloflow", "Centred"): "siloflow, Centred", ("lammps", "Verlet"): "LAMMPS"}
    svg = [f'<rect width="{width}" height="{height}" fill="white"/>', '<text x="20" y="24" font-size="15">Error of the discharge rate against the time of a run on one core</text>',
           f'<rect x="{left}" y="{y(1):.1f}" width="{width - left - right}" height="{y(-1) - y(1):.1f}" fill="#eef6ee"/>']
    for number, (key, colour) in enumerate(colours.items()):
        svg += [f'<circle cx="{26 + 160 * number}" cy="42" r="5" fill="{colour}"/>', f'<text x="{38 + 160 * number}" y="47">{names[key]}</text>']
    for error in range(least, most + 1, 1 if most - least <= 10 else 2):
        svg += [f'<line x1="{left}" y1="{y(error):.1f}" x2="{width - right}" y2="{y(error):.1f}" stroke="#ddd"/>',
                f'<text x="{left - 8}" y="{y(error) + 4:.1f}" text-anchor="end">{error}</text>']
    for time in (digit * 10**power for power in range(6) for digit in (1, 2, 5)):
        if low <= time <= high:
            svg += [f'<line x1="{x(time):.1f}" y1="{top}" x2="{x(time):.1f}" y2="{height - bottom}" stroke="#eee"/>',
                    f'<text x="{x(time):.1f}" y="{height - bottom + 18}" text-anchor="middle">{time}</text>']
    svg += [f'<text x="{(left + width) / 2:.0f}" y="{height - 14}" text-anchor="middle">time of a run, s</text>',
            f'<text x="20" y="{(top + height - bottom) / 2:.0f}" text-anchor="middle" transform="rotate(-90 20 {(top + height - bottom) / 2:.0f})">error of the rate, %</text>']
    for number, ((program, scheme, soft, step, grains), wall, off, error) in enumerate(points):
        colour = colours[(program, scheme)]
        svg += [f'<line x1="{x(wall):.1f}" y1="{y(off - error):.1f}" x2="{x(wall):.1f}" y2="{y(off + error):.1f}" stroke="{colour}" stroke-width="1.5"/>',
                f'<circle cx="{x(wall):.1f}" cy="{y(off):.1f}" r="5" fill="{colour}"/>']
        label = f"E/{1 / float(soft):.0f}, {1e6 * float(step):.3g} us" + ("" if int(grains) == 30_000 else f", {int(grains) // 1000}k")
        place = y(off + error) - 6 if number % 2 else y(off - error) + 14
        svg.append(f'<text x="{x(wall):.1f}" y="{place:.1f}" text-anchor="middle" font-size="11" fill="{colour}">{label}</text>')
    FIGURE.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
                      'font-family="Ubuntu, sans-serif" font-size="13">\n' + "\n".join(svg) + "\n</svg>\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--siloflow", type=pathlib.Path, default=pathlib.Path("target/release/siloflow"))
    parser.add_argument("--lmp", default="lmp")
    parser.add_argument("--dir", type=pathlib.Path, default=pathlib.Path("target/time-to-rate"), help="for the runs")
    parser.add_argument("--csv", type=pathlib.Path, default=HERE / "time-to-rate.csv")
    parser.add_argument("--core", default="0")
    parser.add_argument("--table", action="store_true", help="only print the table and draw the figure")
    args = parser.parse_args()
    args.siloflow, args.dir = args.siloflow.resolve(), args.dir.resolve()
    args.dir.mkdir(parents=True, exist_ok=True)
    rows = []
    if args.csv.exists():
        with args.csv.open(newline="") as file:
            rows = list(csv.reader(file))[1:]
    done = {tuple(row[:6]) for row in rows}
    for row in () if args.table else ROWS:
        for seed in range(1, row[5] + 1):
            if tuple(map(str, (*row[:5], seed))) in done:
                continue
            rows.append(list(map(str, measure(args, row, seed))))
            print(*rows[-1], flush=True)
            with args.csv.open("w", newline="") as file:
                writer = csv.writer(file, lineterminator="\n")
                writer.writerow(COLUMNS)
                writer.writerows(rows)
    draw(report(rows))


if __name__ == "__main__":
    main()
