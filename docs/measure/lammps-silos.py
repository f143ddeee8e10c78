#!/usr/bin/env python3
"""Three silos, filled and discharged by siloflow and by LAMMPS from the same export, on 1 and 2 ranks: rates and times.

    python3 docs/measure/lammps-silos.py --siloflow target/release/siloflow [--seeds 4] [--csv lammps-silos.csv] [--check]

Needs the standard library, LAMMPS with its GRANULAR package as `lmp`, and `mpirun` (Debian: lammps, openmpi-bin). The scenes are in the
folder `lammps` beside this file. Each seed gives another filling. Both programs fill, wait for rest, open the door and discharge.

The rate is that from 10 to 90 % of the grains that leave, read from `series.csv` of both programs in the same way. The runs are chaotic,
and sums over MPI have another order on 2 ranks, so only means over seeds compare: a row passes if the means differ by at most 3.7 combined
standard errors, which by chance fails once in 100 rows (Student's t, 6 degrees of freedom: two samples of four seeds). A run in which less
than half of the grains leave is clogged: it is kept in the table, and left out of the mean. `--check` ends with 1 if a row fails. Processor time is that of the run with its children; ranks that wait count as busy.
"""

import argparse
import csv
import json
import math
import os
import pathlib
import resource
import subprocess
import sys
import time

SCENES = pathlib.Path(__file__).resolve().parent / "lammps"
NAMES = ("flat", "wedge", "cone")
LIMIT = 3.7


def run(command, folder):
    """Wall-clock and processor time of a command, s."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    environment = dict(os.environ, OMP_NUM_THREADS="1", OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))} failed:\n{done.stdout[-1000:]}{done.stderr[-2000:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.perf_counter() - start, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def crossing(rows, level):
    """Time at which `out` reaches a level, linear between rows."""
    for (t, n), (later, more) in zip(rows, rows[1:]):
        if n < level <= more:
            return t + (later - t) * (level - n) / (more - n)
    sys.exit("the discharge never reached its level")


def figures(folder):
    with open(folder / "series.csv", newline="") as text:
        rows = [(float(row["time_s"]), float(row["out"])) for row in csv.DictReader(line for line in text if line[0] != "#")]
    summary = json.loads((folder / "summary.json").read_text())
    out = summary["grains"]["out"]
    begin, end = crossing(rows, 0.1 * out), crossing(rows, 0.9 * out)
    return {
        "rate_per_s": round(0.8 * out / (end - begin), 3),
        "rest_s": summary["rest_time_s"],
        "left": summary["grains"]["inside"],
        "grains": summary["grains"]["released"],
    }


def measure(options):
    work = pathlib.Path(options.work).resolve()
    work.mkdir(parents=True, exist_ok=True)
    siloflow = str(pathlib.Path(options.siloflow).resolve())
    rows = []
    for name in NAMES:
        for seed in range(1, options.seeds + 1):
            scene, folder = str(SCENES / f"{name}.ron"), work / f"{name}-{seed}"
            times = run([siloflow, "run", scene, "--seed", str(seed), "--out", str(folder), "--force", "--quiet"], work)
            rows.append(row(name, "siloflow", 1, seed, folder, times))
            for ranks in (1, 2):
                folder = work / f"{name}-{seed}-lammps-{ranks}"
                subprocess.run(["rm", "-rf", str(folder)], check=True)
                run([siloflow, "export", scene, "--seed", str(seed), "--to", "lammps", "--out", str(folder), "--quiet"], work)
                launch = ["mpirun", "--oversubscribe", "-np", str(ranks)] if ranks > 1 else []
                times = run([*launch, options.lmp, "-in", "in.silo", "-screen", "none"], folder)
                rows.append(row(name, "lammps", ranks, seed, folder, times))
    return rows


def row(name, program, ranks, seed, folder, times):
    wall, processor = times
    found = {"silo": name, "program": program, "ranks": ranks, "seed": seed, **figures(folder)}
    found |= {"wall_s": round(wall, 2), "processor_s": round(processor, 2)}
    print(" ".join(f"{key}={value}" for key, value in found.items()), flush=True)
    return found


def mean(rows):
    values = [row["rate_per_s"] for row in rows if 2 * row["left"] < row["grains"]]
    if len(values) < len(rows):
        print(f"{len(rows) - len(values)} clogged:", end=" ")
    average = sum(values) / len(values)
    spread = math.sqrt(sum((value - average) ** 2 for value in values) / (len(values) - 1)) if len(values) > 1 else math.nan
    return average, spread / math.sqrt(len(values))


def compare(rows):
    """Prints the table; true if every mean agrees."""
    passed = True
    for name in NAMES:
        def of(program, ranks):
            return [row for row in rows if (row["silo"], row["program"], row["ranks"]) == (name, program, ranks)]

        ours, error = mean(of("siloflow", 1))
        print(f"{name:6s} siloflow          {ours:8.2f} +- {error:.2f} grains/s")
        for ranks in (1, 2):
            theirs, other = mean(of("lammps", ranks))
            off = (theirs - ours) / math.hypot(error, other)
            good = abs(off) <= LIMIT
            passed &= good
            print(f"{name:6s} LAMMPS, {ranks} rank{'s' if ranks > 1 else ' '}   {theirs:8.2f} +- {other:.2f} grains/s, "
                  f"{off:+.2f} combined standard errors: {'PASS' if good else 'FAIL'}")
    return passed


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--siloflow", required=True, help="the siloflow program")
    parser.add_argument("--lmp", default="lmp", help="the LAMMPS program")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--csv", default="lammps-silos.csv", help="table to write")
    parser.add_argument("--work", default="lammps-silos-work", help="folder for inputs and outputs")
    parser.add_argument("--check", action="store_true", help="end with 1 if rates differ")
    options = parser.parse_args()
    rows = measure(options)
    with open(options.csv, "w", newline="") as out:
        writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    if not compare(rows) and options.check:
        sys.exit(1)


if __name__ == "__main__":
    main()
