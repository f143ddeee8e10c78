#!/usr/bin/env python3
"""Time and memory from a thousand to ten million grains, and from 1e4 to 1e8 sites of the lattice gas, as a table.

    apt-get install --no-install-recommends lammps
    cargo build --release
    for bed in w1-1e3 w1-1e4 w1-1e5; do docs/speed/side-by-side.py settle $bed; done
    docs/speed/scaling.py                              (all sizes: an hour and more, some GB of memory and disk)
    docs/speed/scaling.py --grains 1e3,1e5 --sites ''  (some; rows of other sizes are kept)
    cargo run --release --example figures -- scaling   (draws docs/figures/scaling from the table)

Grains: settled beds of W1 (plane, no friction; see side-by-side.py); of 1e5 grains and more, the bed of 1e5 side by side. A run
of --relax steps leaves the state with which the next runs begin. The steps after it are timed: the wall clock of a run of
1 + n steps less that of a run of one step, n at least --last and enough for 1e8 particle-steps. All runs are
those of the program as a user calls it, on one core, without pictures.

Sites: a closed box of 250 rows, as many columns as that takes, filled with 6 particles a site, the rules those of
scenes/funnel-flow.ron. The mean is over the first --lattice-steps from the fill on, the same for every size, for a bed that has
settled costs less; of small lattices, the median of up to nine runs.

Bytes are the largest resident set of all runs up to their last step (VmHWM), program (10 MB) and set-up included, over grains or sites.
"""

import argparse
import csv
import importlib.util
import math
import os
import pathlib
import shutil
import statistics
import sys

# No __pycache__ beside the module.
sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
SPEC = importlib.util.spec_from_file_location("side_by_side", HERE / "side-by-side.py")
side = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(side)

COLUMNS = ["method", "count", "contacts", "steps", "ns", "bytes"]
ROWS = 250
TILE = 100_000

LATTICE = """(
    seed: 1,
    method: LatticeGas(spacing: 0.01, p: 0.2, q: 0.2, b: 0.05, k: 0.05, g: 0.2, h: 0.05),
    outline: [({low!r}, 0.0), ({high!r}, 0.0), ({high!r}, 2.495), ({low!r}, 2.495)],
    fill: (per_site: 6.0),
    until: {until},
    series: (interval: 4000000000),
    pictures: None,
)
"""


def grains(args, count):
    bed, copies = (f"w1-1e{round(math.log10(count))}", 1) if count < TILE else ("w1-1e5", count // TILE)
    dt = side.BEDS[bed]["dt"]
    scene, _ = side.write_scene(args, bed, copies)
    relaxed, out = side.siloflow(args, scene, dt, args.relax)
    os.replace(out / "state.csv", scene.with_suffix(".csv"))
    inside = relaxed["grains"]["inside"]
    steps = max(args.last, 100_000_000 // inside)
    one, _ = side.siloflow(args, scene, dt, 1)
    many, _ = side.siloflow(args, scene, dt, 1 + steps)
    costs = [summary["performance"] for summary in (relaxed, one, many)]
    if copies > 1:
        scene.with_suffix(".csv").unlink()
    return {
        "method": "grains",
        "count": inside,
        "contacts": f"{many['coordination']:.3f}",
        "steps": args.relax + 1 + steps,
        "ns": f"{(costs[2]['wall_s'] - costs[1]['wall_s']) / steps / inside * 1e9:.2f}",
        "bytes": f"{max(cost['peak_memory_bytes'] for cost in costs) / inside:.1f}",
    }


def lattice(args, count):
    # Columns are half the root of three spacings apart, and set into the middle.
    half = 0.5 * (count // ROWS - 1) * 0.01 * math.sqrt(0.75) + 1e-3
    steps = args.lattice_steps
    scene = args.dir / "lattice.ron"
    scene.write_text(LATTICE.format(low=-half, high=half, until=steps))
    command = ["taskset", "-c", args.core, args.siloflow, "run", scene, "--force", "--out", args.dir / "out", "--quiet", "--json"]
    rounds = min(9, max(1, 300_000_000 // (count * steps)))
    summaries = [side.json.loads(side.sh(command)) for _ in range(rounds)]
    costs, sites = [summary["performance"] for summary in summaries], summaries[0]["sites"]
    return {
        "method": "lattice",
        "count": sites,
        "contacts": "",
        "steps": steps,
        "ns": f"{statistics.median(cost['wall_s'] for cost in costs) / steps / sites * 1e9:.2f}",
        "bytes": f"{max(cost['peak_memory_bytes'] for cost in costs) / sites:.2f}",
    }


def keep(path, row):
    """Puts a row into the table, in place of the one of the same size."""
    rows = list(csv.DictReader(path.open())) if path.exists() else []
    rows = [old for old in rows if (old["method"], int(old["count"])) != (row["method"], row["count"])] + [row]
    rows.sort(key=lambda row: (row["method"], int(row["count"])))
    with path.open("w", newline="") as file:
        out = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        out.writeheader()
        out.writerows(rows)


def sizes(text):
    return [round(float(word)) for word in text.split(",") if word]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grains", type=sizes, default=sizes("1e3,1e4,1e5,1e6,1e7"))
    parser.add_argument("--sites", type=sizes, default=sizes("1e4,1e5,1e6,1e7,1e8"))
    parser.add_argument("--relax", type=int, default=1500)
    parser.add_argument("--last", type=int, default=500)
    parser.add_argument("--lattice-steps", type=int, default=400)
    parser.add_argument("--csv", type=pathlib.Path, default=HERE / "scaling.csv")
    parser.add_argument("--siloflow", type=pathlib.Path, default=pathlib.Path("target/release/siloflow"))
    parser.add_argument("--dir", type=pathlib.Path, default=pathlib.Path("target/side-by-side"))
    parser.add_argument("--integrator", default="Verlet")
    parser.add_argument("--skin", type=float, help="m")
    parser.add_argument("--core", default="0")
    args = parser.parse_args()
    args.threads, args.dir, args.siloflow = 1, args.dir.resolve(), args.siloflow.resolve()
    args.dir.mkdir(parents=True, exist_ok=True)
    for what, counts in ((grains, args.grains), (lattice, args.sites)):
        for count in counts:
            row = what(args, count)
            keep(args.csv, row)
            print(", ".join(f"{key} {value}" for key, value in row.items()), flush=True)
    shutil.rmtree(args.dir / "out", ignore_errors=True)


if __name__ == "__main__":
    main()
