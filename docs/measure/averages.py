#!/usr/bin/env python3
"""Discharge rate, rest time and packing of a silo by scheme and step, over seeds: what a step has to cost for 1 %.

    cargo build --release
    docs/measure/averages.py [--seeds 42] [--siloflow target/release/siloflow]     (writes averages.csv beside it; a few minutes)

The silo is scenes/silo1.ron with 300 grains, released every 0.03 s. Its steps are 0.99, 1/2 and 1/4 of the limit of a dense bed that `siloflow check`
prints for the scheme. Seeds are the outermost loop, so that all rows share the load of the machine. For each quantity: mean and
standard error over the seeds, the difference from the mean of the finest steps of both schemes, and whether it is visible: beyond three
standard errors of the difference. The last lines give the standard deviation of a single run and the number of seeds at which a difference of 1 % would
be visible, 2 (3 s/1 %)^2. Times are those of the steps of a run, median over the seeds.
"""

import argparse
import csv
import json
import math
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SCENE = HERE.parent.parent / "scenes/silo1.ron"
SCHEMES, SHARES, VISIBLE = ("Verlet", "Centred"), (0.99, 0.5, 0.25), 3.0
QUANTITIES = ("discharge_per_s", "rest_time_s", "packing_fraction")
SETTINGS = ("--set", "spawner.count=300", "--set", "spawner.interval=0.03", "--set", "pictures=None", "--set", "bed=(low: (-0.4, 0.9), high: (0.4, 1.2))")
COLUMNS = ("scheme", "share_of_limit", "step_s", "seed", *QUANTITIES, "steps", "wall_s")


def siloflow(args, *words):
    done = subprocess.run([args.siloflow, *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{words}\n{done.stdout[-800:]}{done.stderr[-800:]}")
    return done.stdout


def limit(args, scheme):
    text = siloflow(args, "check", SCENE, *SETTINGS, "--set", f"integrator={scheme}")
    return float(re.search(r"(\S+) s in a dense bed", text)[1])


def single(args, folder, scheme, dt, seed):
    summary = json.loads(siloflow(args, "run", SCENE, *SETTINGS, "--set", f"integrator={scheme}", "--set", f"step=Fixed({dt!r})", "--set",
                                  f"seed={seed}", "--force", "--out", folder / "out", "--quiet", "--json"))
    return [summary["discharge"]["rate_per_s"], summary["rest_time_s"], summary["bed"]["packing_fraction"], summary["steps"],
            summary["performance"]["wall_s"]]


def mean_and_error(values):
    return statistics.fmean(values), statistics.stdev(values) / math.sqrt(len(values))


def report(rows):
    groups = {}
    for scheme, share, dt, _, *found in rows:
        groups.setdefault((scheme, share, dt), []).append([float(x) for x in found])
    finest = [found for (_, share, _), found in groups.items() if float(share) == SHARES[-1]]
    print("| scheme | step, s | " + " | ".join(QUANTITIES) + " | s a run |\n|---|---|" + "---|" * len(QUANTITIES) + "---|")
    for (scheme, share, dt), found in groups.items():
        cells = []
        for number in range(len(QUANTITIES)):
            mean, error = mean_and_error([run[number] for run in found])
            # A finest step is compared with the other scheme's, any other with both.
            others = [run[number] for other in finest if other is not found for run in other]
            reference, noise = mean_and_error(others)
            apart = mean - reference
            mark = " **" if abs(apart) > VISIBLE * math.hypot(error, noise) else ""
            cells.append(f"{mean:.4g} ± {error:.2g} ({100 * apart / reference:+.1f} %){mark}")
        print(f"| `{scheme}` | {float(dt):.3g}, {float(share):g} of the limit | {' | '.join(cells)} | {statistics.median(run[-1] for run in found):.2f} |")
    for number, name in enumerate(QUANTITIES):
        groups_of = [[run[number] for run in found] for found in groups.values()]
        spread = statistics.fmean(statistics.stdev(values) / statistics.fmean(values) for values in groups_of)
        print(f"{name}: standard deviation of a run {100 * spread:.1f} %; 1 % is visible from {math.ceil(2 * (VISIBLE * spread / 0.01) ** 2)} seeds on")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--siloflow", type=pathlib.Path, default=pathlib.Path("target/release/siloflow"))
    parser.add_argument("--seeds", type=int, default=42)
    parser.add_argument("--csv", type=pathlib.Path, default=HERE / "averages.csv")
    parser.add_argument("--report", action="store_true", help="only report what the csv holds")
    args = parser.parse_args()
    args.siloflow = args.siloflow.resolve()
    if not args.report:
        limits = {scheme: limit(args, scheme) for scheme in SCHEMES}
        with tempfile.TemporaryDirectory() as folder, args.csv.open("w", newline="") as out:
            writer = csv.writer(out, lineterminator="\n")
            writer.writerow(COLUMNS)
            for seed in range(1, args.seeds + 1):
                for scheme, most in limits.items():
                    for share in SHARES:
                        dt = float(f"{share * most:.4g}")
                        found = single(args, pathlib.Path(folder), scheme, dt, seed)
                        writer.writerow([scheme, share, dt, seed, *(f"{x:.6g}" for x in found)])
                out.flush()
    with args.csv.open() as file:
        report(list(csv.reader(file))[1:])


if __name__ == "__main__":
    main()
