#!/usr/bin/env python3
"""Silos that are filled with soft grains and emptied with stiff ones, beside silos that are filled and emptied with stiff ones: five small silos in plane
and solid space.

    cargo build --release
    docs/measure/soft-filling.py [--runs 20] [--only NAME ...] [--siloflow PATH]     (about an hour on one core)

The soft grains have radii that are larger by a share g (the scene key `growth`). Once they rest, a second run takes their centres, with the stiffness and radii
of the scene: grains that have shrunk settle a little. Two choices of g: half of the mean overlap at rest of one soft run, so that grains just touch on average,
and half of its largest overlap, so that none overlaps. Each row is the change from the silo that is filled with stiff grains, in per cent, with its standard error; `steps`
are those of both runs. The other figures are those of growth.py.
"""

import argparse
import csv
import json
import pathlib
import re
import subprocess
import sys
import tempfile

from growth import CASES, END, FIGURES, ROOT, average, figures_of

# The softness of the grains that fill, over that of the reference.
SOFT = {"Linear": 30, "Hertz": 300}


def call(siloflow, scene, out, *settings):
    words = [siloflow, "run", scene, "--out", out, "--force", "--quiet", *settings]
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{done.args} failed:\n{done.stderr}")
    return json.loads((out / "summary.json").read_text())


def steps(summary):
    return summary["performance"]["particle_steps"]


def fill(siloflow, scene, folder, soft, growth, seed):
    """Fills with soft grains, up to rest; returns the summary."""
    settings = ["--set", f"parameters.soft={soft}", "--set", f"growth={growth}", "--set", "door.opens=Never", "--set", "rest.stop=true", "--seed", seed]
    return call(siloflow, scene, folder / "soft", *settings)


def shrunk(state, growth, target):
    """Writes the grains of a state with their radii without growth, at rest."""
    with open(state, encoding="utf-8") as file, open(target, "w", encoding="utf-8", newline="") as out:
        rows = csv.DictReader(file)
        writer = csv.DictWriter(out, rows.fieldnames)
        writer.writeheader()
        for row in rows:
            row["radius"] = f"{float(row['radius']) / (1 + growth):.17g}"
            row.update({name: "0" for name in ("vx", "vy", "vz", "wx", "wy", "wz") if name in row})
            writer.writerow(row)


def overlaps_at_rest(folder):
    """The mean and the largest overlap in the last row of a run up to rest."""
    with open(folder / "series.csv", encoding="utf-8") as file:
        last = list(csv.DictReader(file))[-1]
    return float(last["mean_overlap_ratio"]), float(last["largest_overlap_ratio"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--only", nargs="*", help="names of silos, or parts of them")
    parser.add_argument("--siloflow", default=ROOT / "target/release/siloflow", type=pathlib.Path)
    arguments = parser.parse_args()
    siloflow = arguments.siloflow.resolve()
    if not siloflow.exists():
        sys.exit(f"{siloflow} is missing: run `cargo build --release`")
    print("| silo | g | " + " | ".join(FIGURES) + " | steps |\n|" + "---|" * (3 + len(FIGURES)))
    seeds = range(1, arguments.runs + 1)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        poured, second = folder / "poured.ron", folder / "second.ron"
        for name, text, reference, _ in CASES:
            if arguments.only and not any(part in name for part in arguments.only):
                continue
            text = text.replace("END", END)
            poured.write_text(text)
            second.write_text(re.sub(r"fill: \[.*\],\n", 'grains: (file: "grains.csv"),\n', text))
            reference_setting = ["--set", f"parameters.soft={reference}"]
            found, cost = [], 0
            for seed in seeds:
                summary = call(siloflow, poured, folder / "run", *reference_setting, "--seed", seed)
                cost += steps(summary)
                found.append(figures_of(folder / "run")[0])
            base = average(found)
            soft = reference * next(soft for law, soft in SOFT.items() if law + "(" in text)
            fill(siloflow, poured, folder, soft, 0.0, 1)
            for overlap in overlaps_at_rest(folder / "soft"):
                growth = round(0.5 * overlap, 5)
                found, spent = [], 0
                for seed in seeds:
                    summary = fill(siloflow, poured, folder, soft, growth, seed)
                    spent += steps(summary)
                    filled = summary["rest_time_s"]
                    shrunk(folder / "soft" / "state.csv", growth, folder / "grains.csv")
                    spent += steps(call(siloflow, second, folder / "run", *reference_setting, "--seed", seed))
                    figures = figures_of(folder / "run")[0]
                    if figures and filled:
                        figures["rest"] += filled
                    found.append(figures)
                own = average(found)
                cells = []
                for figure in FIGURES:
                    (mean, error, count), (exact, own_error, _) = own[figure], base[figure]
                    missing = f" ({count} runs)" if count < arguments.runs else ""
                    cells.append(f"{100 * (mean / exact - 1):+.1f} ± {100 * (error**2 + own_error**2) ** 0.5 / abs(exact):.1f}{missing}")
                print(f"| {name} | {growth:g} | " + " | ".join(cells) + f" | {100 * (spent / cost - 1):+.0f} |", flush=True)


if __name__ == "__main__":
    main()
