#!/usr/bin/env python3
"""Cost of a run besides its steps: pictures, rows, profiles, the watchdog, the energy balance.

    cargo build --release
    docs/speed/costs.py scenes/silo1.ron                    (processor and wall-clock time, medians and least)
    docs/speed/costs.py scenes/silo1.ron --exact            (instructions, counted by valgrind: no noise, fifty times slower;
                                                             where memory is set or copied at once it counts every byte)
    docs/speed/costs.py scenes/bed3d.ron -- --until 0.05    (what follows -- goes to every run)
    docs/speed/costs.py --start                             (a run of one step, from the call to its end)

Runs: the scene unchanged, the scene with PNGs, the scene whose energy balance sums dissipation in every step, and the scene
with one output left out. A cost is the difference of two
runs. Each round makes every run once, in a rotating order, so that the load of the machine affects all runs alike;
differences are taken within a round. Printed are medians over the rounds, the least in brackets, and each cost as a share of
the run that includes it. Times are those of the whole process: start-up, steps, output.

Processor time is that of all threads together. Pictures are drawn by a thread of their own, so wall-clock time differs with
the cores: --cores 0 pins everything to one core, --cores 0,1 to two. --log FILE keeps every run, and takes up what an earlier
call has put there. No packages needed.
"""

import argparse
import csv
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

SILENT = "series=(interval:1e9)"
WHOLE = "as in the scene"
# Settings of each run, and the two runs whose difference is a cost: the more expensive one first.
RUNS = {
    WHOLE: ([], None),
    "PNGs too": (["--png"], ("PNGs too", "no pictures")),
    "no pictures": (["pictures=None"], (WHOLE, "no pictures")),
    "no rows": ([SILENT], (WHOLE, "no rows")),
    "no profiles": (["profiles=[]"], (WHOLE, "no profiles")),
    "no flow field": (["flow=None"], (WHOLE, "no flow field")),
    "no watchdog": (["watchdog=None"], (WHOLE, "no watchdog")),
    "no balance": (["energy_balance=false"], (WHOLE, "no balance")),
    "all in balance": (["energy_balance_every=1"], ("all in balance", "no balance")),
    "none of these": (["pictures=None", SILENT, "watchdog=None"], (WHOLE, "none of these")),
}
ONLY_WITH = {"no profiles": "profiles", "no flow field": "flow"}


def runs_of(scene):
    """What there is to leave out of this scene."""
    text = re.sub(r"//.*", "", scene.read_text())
    has = {key for key in ("profiles", "flow") if re.search(rf"^    {key}:", text, re.M)}
    runs = {name: list(words) for name, (words, _) in RUNS.items() if ONLY_WITH.get(name) in (None, *has)}
    runs["none of these"] += [f"{key}={'[]' if key == 'profiles' else 'None'}" for key in sorted(has)]
    return runs


def command(args, scene, words, out):
    line = [args.siloflow, "run", scene, "--force", "--out", out, "--quiet", *args.more]
    for word in words:
        line += [word] if word.startswith("--") else ["--set", word]
    return [str(word) for word in line]


def timed(args, line):
    """Processor and wall-clock time of a process, s."""
    begin = time.perf_counter()
    process = subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                               preexec_fn=lambda: os.sched_setaffinity(0, args.cores))
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - begin
    if status:
        sys.exit(f"failed: {' '.join(line)}")
    return usage.ru_utime + usage.ru_stime, wall


def counted(line, folder):
    """Instructions of a process: of all threads, and of the one that steps."""
    files = pathlib.Path(folder) / "counts"
    done = subprocess.run(["valgrind", "--tool=callgrind", "--separate-threads=yes", f"--callgrind-out-file={files}", *line],
                          capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"failed: {' '.join(line)}\n{done.stderr[-2000:]}")
    threads = {}
    for file in pathlib.Path(folder).glob("counts*"):
        total = re.search(r"^(?:totals|summary): (\d+)", file.read_text(errors="replace"), re.M)
        threads[file.name] = int(total[1]) if total else 0
        file.unlink()
    first = min((name for name in threads if threads[name]), key=lambda name: name)
    return sum(threads.values()), threads[first]


def in_brackets(numbers):
    return f"{statistics.median(numbers):.3f} ({min(numbers):.3f})"


def times(args, scene, folder):
    runs, records = runs_of(scene), []
    if args.log and args.log.exists():
        with args.log.open() as file:
            records = [row for row in csv.reader(file) if row[0] == str(scene)]
    for _ in range(args.runs):
        this = 1 + max((int(row[1]) for row in records), default=-1)
        turn = this % len(runs)
        for name in [*runs][turn:] + [*runs][:turn]:
            records.append([str(scene), str(this), name, *map(repr, timed(args, command(args, scene, runs[name], folder)))])
            if args.log:
                with args.log.open("a", newline="") as file:
                    csv.writer(file).writerow(records[-1])
    at = {name: {row[1]: (float(row[3]), float(row[4])) for row in records if row[2] == name} for name in runs}
    print(f"{scene.stem} {' '.join(args.more)}: {len(at[WHOLE])} rounds, cores {sorted(args.cores)}")
    print(f"{'':16}{'processor, s':>18}{'wall clock, s':>18}   the difference: of processor, of wall clock")
    for name, by_round in at.items():
        line = f"{name:16}" + "".join(f"{in_brackets([both[n] for both in by_round.values()]):>18}" for n in (0, 1))
        if two := RUNS[name][1]:
            line += "".join(f"{share(at, *two, n):8.1f} %" for n in (0, 1))
        print(line)


def share(at, dearer, cheaper, n):
    """The median of the differences within a round, of the median of the dearer."""
    both = [(at[dearer][this][n], at[cheaper][this][n]) for this in at[dearer] if this in at[cheaper]]
    return 100 * statistics.median(a - b for a, b in both) / statistics.median(a for a, _ in both)


def counts(args, scene, folder):
    runs, out = runs_of(scene), pathlib.Path(folder) / "out"
    at = {name: counted(command(args, scene, words, out), folder) for name, words in runs.items()}
    print(f"{scene.stem} {' '.join(args.more)}: instructions")
    print(f"{'':16}{'all threads':>18}{'stepping thread':>18}   the difference: of all, of stepping thread")
    for name, both in at.items():
        line = f"{name:16}{both[0]:18,}{both[1]:18,}"
        if two := RUNS[name][1]:
            line += "".join(f"{100 * (1 - at[two[1]][n] / at[two[0]][n]):8.2f} %" for n in (0, 1))
        print(line)


def start(args, folder):
    scene = args.scenes[0] if args.scenes else pathlib.Path("scenes/silo1.ron")
    line = command(args, scene, ["until=1e-9"], folder)
    both = [timed(args, line) for _ in range(max(args.runs, 21))]
    print(f"{scene.stem}, one step: processor {in_brackets([b[0] for b in both])} s, wall clock {in_brackets([b[1] for b in both])} s")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--siloflow", type=pathlib.Path, default=pathlib.Path("target/release/siloflow"))
    parser.add_argument("--runs", type=int, default=9, help="rounds")
    parser.add_argument("--cores", type=lambda text: {int(core) for core in text.split(",")}, default={0})
    parser.add_argument("--exact", action="store_true")
    parser.add_argument("--start", action="store_true")
    parser.add_argument("--log", type=pathlib.Path)
    words = sys.argv[1:]
    cut = words.index("--") if "--" in words else len(words)
    args = parser.parse_args(words[:cut])
    args.more = words[cut + 1:]
    args.siloflow = args.siloflow.resolve()
    if not args.start and not args.scenes:
        parser.error("a scene is missing")
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        if args.start:
            return start(args, out)
        for scene in args.scenes:
            counts(args, scene, folder) if args.exact else times(args, scene, out)


if __name__ == "__main__":
    main()
