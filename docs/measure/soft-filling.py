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

import csv
import json
import pathlib
import re
import tempfile

import growth

# The softness of the grains that fill, over that of the reference.
SOFT = {"Linear": 30, "Hertz": 300}


def run(siloflow, scene, out, *settings):
    """Runs a scene, and returns its summary."""
    growth.call(siloflow, scene, out, *settings)
    return json.loads((out / "summary.json").read_text())


def steps(summary):
    return summary["performance"]["particle_steps"]


def fill(siloflow, scene, folder, soft, grown, seed):
    """Fills with soft grains, up to rest; returns the summary."""
    settings = ["--set", f"parameters.soft={soft}", "--set", f"growth={grown}", "--set", "door.opens=Never", "--set", "rest.stop=true", "--seed", seed]
    return run(siloflow, scene, folder / "soft", *settings)


def shrink(state, grown, target):
    """Writes the grains of a state with their radii without growth, at rest."""
    with open(state, encoding="utf-8") as file, open(target, "w", encoding="utf-8", newline="") as out:
        rows = csv.DictReader(file)
        writer = csv.DictWriter(out, rows.fieldnames)
        writer.writeheader()
        for row in rows:
            row["radius"] = f"{float(row['radius']) / (1 + grown):.17g}"
            row.update({name: "0" for name in ("vx", "vy", "vz", "wx", "wy", "wz") if name in row})
            writer.writerow(row)


def overlaps_at_rest(folder):
    """The mean and the largest overlap in the last row of a run up to rest."""
    with open(folder / "series.csv", encoding="utf-8") as file:
        last = list(csv.DictReader(file))[-1]
    return float(last["mean_overlap_ratio"]), float(last["largest_overlap_ratio"])


def main():
    arguments = growth.options(__doc__, 20)
    siloflow = arguments.siloflow
    print("| silo | g | " + " | ".join(growth.FIGURES) + " | steps |\n|" + "---|" * (3 + len(growth.FIGURES)))
    seeds = range(1, arguments.runs + 1)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        poured, second = folder / "poured.ron", folder / "second.ron"
        for name, text, reference, _ in growth.chosen(arguments):
            poured.write_text(text)
            second.write_text(re.sub(r"fill: \[.*\],\n", 'grains: (file: "grains.csv"),\n', text))
            stiff = ["--set", f"parameters.soft={reference}"]
            found, cost = [], 0
            for seed in seeds:
                cost += steps(run(siloflow, poured, folder / "run", *stiff, "--seed", seed))
                found.append(growth.figures_of(folder / "run")[0])
            base = growth.average(found)
            soft = reference * next(soft for law, soft in SOFT.items() if law + "(" in text)
            fill(siloflow, poured, folder, soft, 0.0, 1)
            for overlap in overlaps_at_rest(folder / "soft"):
                grown = round(0.5 * overlap, 5)
                found, spent = [], 0
                for seed in seeds:
                    summary = fill(siloflow, poured, folder, soft, grown, seed)
                    shrink(folder / "soft" / "state.csv", grown, folder / "grains.csv")
                    spent += steps(summary) + steps(run(siloflow, second, folder / "run", *stiff, "--seed", seed))
                    figures = growth.figures_of(folder / "run")[0]
                    if figures and summary["rest_time_s"]:
                        figures["rest"] += summary["rest_time_s"]
                    found.append(figures)
                cells = growth.changes(growth.average(found), base, arguments.runs)
                print(f"| {name} | {grown:g} | {cells} | {100 * (spent / cost - 1):+.0f} |", flush=True)


if __name__ == "__main__":
    main()
