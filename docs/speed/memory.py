#!/usr/bin/env python3
"""Bytes per grain of a run: at its peak, and while it steps.

    cargo build --release
    docs/speed/side-by-side.py scene w1-1e5             (writes scene and grains of a settled bed; `settle` makes it)
    docs/speed/memory.py target/side-by-side/w1-1e5.ron [--steps 200] [--set KEY=VALUE]...

Counted is the resident memory of the whole program, from /proc/PID/status. The program itself takes 13 MB, which shows with few
grains. The peak is the maximum resident set size of the kernel, at least the 15 MB of this script. "Stepping" is the median
of 50 samples per second, so steps should take most of the time.
"""

import argparse
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time


def resident(pid):
    """Resident memory now, bytes; None once it has ended."""
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return None
    found = re.search(r"VmRSS:\s+(\d+) kB", status)
    return 1024 * int(found[1]) if found else None


def run(command):
    """Runs it: what it printed, its peak and its samples, bytes."""
    with tempfile.TemporaryFile() as printed:
        child = subprocess.Popen(command, stdout=printed)
        samples = []
        while True:
            pid, status, usage = os.wait4(child.pid, os.WNOHANG)
            if pid:
                child.returncode = os.waitstatus_to_exitcode(status)
                break
            samples.append(resident(child.pid))
            time.sleep(0.02)
        if child.returncode:
            sys.exit(f"{' '.join(command)}: exit status {child.returncode}")
        printed.seek(0)
        return json.load(printed), 1024 * usage.ru_maxrss, [sample for sample in samples if sample]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--siloflow", default="target/release/siloflow")
    args = parser.parse_args()
    dt = re.search(r"step: *Fixed\(([^)]+)\)", args.scene.read_text())
    if dt is None:
        sys.exit("the scene has no `step: Fixed(...)`")
    with tempfile.TemporaryDirectory() as out:
        command = [args.siloflow, "run", str(args.scene), "--out", f"{out}/run", "--quiet", "--json",
                   "--until", repr(args.steps * float(dt[1]))]
        summary, peak, samples = run(command + [word for setting in args.set for word in ("--set", setting)])
    grains = summary["grains"]["released"]
    print(f"{args.scene.stem}: {grains} grains, {summary['steps']} steps, state {summary['state_hash']}")
    print(f"peak {peak / grains:.0f}, stepping {statistics.median(samples) / grains:.0f} bytes per grain")


if __name__ == "__main__":
    main()
