#!/usr/bin/env python3
"""What larger radii (the scene key `growth`) make of soft grains: five small silos in plane and solid space, each at a reference stiffness and at two softer
ones, without and with growth.

    cargo build --release
    docs/measure/growth.py [--runs 16] [--only NAME ...] [--siloflow PATH]     (less than an hour on one core)

Each row is a mean over runs with different seeds, as the change from the reference in per cent, with its standard error. The growth of a stiffness is half of
its further mean overlap at rest, over the radius, in one run without growth. Figures: `rate`, grains per second while 10 to 90 % leave; `height`,
the mean height of grains at rest above the door; `load`, the pressure on the lower side walls at rest; `moving`, the same while grains flow; `rest`, the time of rest.
"""

import argparse
import csv
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# The end of each scene.
END = """rest: (speed: 0.2, energy: 1.0e-3, hold: 0.02), door: (opens: AtRest), cull: (below: -0.1), until: 6.0,
    series: (interval: 0.01), pictures: None, data_frames: None, checkpoint: None, energy_balance: false,"""
FLAT = """(
    parameters: { "soft": 1.0, "k": "= 1e7 / soft" },
    gravity: (0.0, -9.81),
    contact: Linear(k: "= k", damping: Restitution(0.5), tangential: Spring(k: "= k * 2 / 7", damping: OfNormal(0.5), friction: 0.5)),
    mass: Disc(2500.0), integrator: Verlet, step: Auto(error: 0.05),
    walls: [Segment(from: (-0.1, 0.0), to: (-0.1, 1.0), name: "sides"), Segment(from: (0.1, 0.0), to: (0.1, 1.0), name: "sides"),
        Segment(from: (-0.1, 0.0), to: (-0.03, 0.0), name: "floor"), Segment(from: (0.03, 0.0), to: (0.1, 0.0), name: "floor"), Segment(from: (-0.03, 0.0), to: (0.03, 0.0), door: true)],
    fill: [(low: (-0.1, 0.0), high: (0.1, 0.9), spacing: 0.0115, count: 500, radius: Uniform(4.5e-3, 5.5e-3), agitation: (0.3, 0.3))],
    stop: [Out(330)], END
    wall_bands: [(walls: "sides", low: 0.0, high: 0.15, bins: 1, sample: 0.005, average: 0.05), ],
)"""
WEDGE = """(
    parameters: { "soft": 1.0, "k": "= 1e7 / soft" },
    gravity: (0.0, -9.81),
    contact: Linear(k: "= k", damping: Restitution(0.5), tangential: Spring(k: "= k * 2 / 7", damping: OfNormal(0.5), friction: 0.2)),
    mass: Disc(2500.0), integrator: Verlet, step: Auto(error: 0.05),
    walls: [Segment(from: (-0.1, 0.0), to: (-0.1, 1.0), name: "sides"), Segment(from: (0.1, 0.0), to: (0.1, 1.0), name: "sides"),
        Segment(from: (-0.1, 0.1), to: (-0.04, 0.0), name: "floor"), Segment(from: (0.04, 0.0), to: (0.1, 0.1), name: "floor"), Segment(from: (-0.04, 0.0), to: (0.04, 0.0), door: true)],
    fill: [(low: (-0.1, 0.1), high: (0.1, 1.0), spacing: 0.0115, count: 500, radius: Uniform(4.5e-3, 5.5e-3), agitation: (0.3, 0.3))],
    stop: [Out(380)], END
    wall_bands: [(walls: "sides", low: 0.1, high: 0.2, bins: 1, sample: 0.005, average: 0.05), ],
)"""
SLOT = """(
    parameters: { "soft": 1.0, "young": "= 1e8 / soft" }, space: Solid,
    gravity: (0.0, 0.0, -9.81), periodic: (y: (0.0, 0.03)),
    contact: Hertz(restitution: 0.5, tangential: Mindlin(friction: 0.4)), materials: [(young: "= young", poisson: 0.25)],
    mass: Sphere(2500.0), integrator: Verlet, step: Auto(error: 0.05),
    walls: [Panel(corner: (-0.04, 0.0, 0.0), along: (0.0, 0.03, 0.0), across: (0.0, 0.0, 0.5), name: "sides"), Panel(corner: (0.04, 0.0, 0.0), along: (0.0, 0.03, 0.0), across: (0.0, 0.0, 0.5), name: "sides"),
        Panel(corner: (-0.04, 0.0, 0.0), along: (0.025, 0.0, 0.0), across: (0.0, 0.03, 0.0)), Panel(corner: (0.015, 0.0, 0.0), along: (0.025, 0.0, 0.0), across: (0.0, 0.03, 0.0)),
        Panel(corner: (-0.015, 0.0, 0.0), along: (0.03, 0.0, 0.0), across: (0.0, 0.03, 0.0), door: true)],
    fill: [(low: (-0.04, 0.0, 0.0), high: (0.04, 0.03, 0.4), spacing: 7.2e-3, count: 800, radius: Uniform(2.85e-3, 3.15e-3), jitter: 3.0e-4)],
    stop: [Out(550)], END
    wall_bands: [(walls: "sides", low: 0.0, high: 0.06, bins: 1, sample: 0.005, average: 0.05), ],
)"""
CYLINDER = """(
    parameters: { "soft": 1.0, "young": "= 1e8 / soft" }, space: Solid,
    gravity: (0.0, 0.0, -9.81),
    contact: Hertz(restitution: 0.6, tangential: Mindlin(friction: 0.3)), materials: [(young: "= young", poisson: 0.25)],
    mass: Sphere(2500.0), integrator: Verlet, step: Auto(error: 0.05),
    walls: [Cylinder(from: (0.0, 0.0, 0.0), to: (0.0, 0.0, 0.3), radius: 0.026, name: "sides"), Annulus(centre: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0), inner: 0.01, outer: 0.026),
        Annulus(centre: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0), outer: 0.01, door: true)],
    fill: [(low: (-0.0175, -0.0175, 0.0), high: (0.0175, 0.0175, 0.3), spacing: 4.9e-3, count: 900, radius: Uniform(1.9e-3, 2.1e-3), jitter: 2.0e-4)],
    stop: [Out(650)], END
    wall_bands: [(walls: "sides", low: 0.0, high: 0.04, bins: 1, sample: 0.005, average: 0.05), ],
)"""
CONE = """(
    parameters: { "soft": 1.0, "k": "= 3e4 / soft" }, space: Solid,
    gravity: (0.0, 0.0, -9.81),
    contact: Linear(k: "= k", damping: Restitution(0.5), tangential: Spring(k: "= k * 2 / 7", damping: OfNormal(0.5), friction: 0.5)),
    mass: Sphere(2500.0), integrator: Verlet, step: Auto(error: 0.05),
    walls: [Cylinder(from: (0.0, 0.0, 0.03), to: (0.0, 0.0, 0.4), radius: 0.03, name: "sides"), Cone(from: (0.0, 0.0, 0.0), to: (0.0, 0.0, 0.03), radii: (0.01, 0.03)),
        Annulus(centre: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0), outer: 0.01, door: true)],
    fill: [(low: (-0.02, -0.02, 0.03), high: (0.02, 0.02, 0.4), spacing: 6.2e-3, count: 800, radius: Mixture([(2.0e-3, 0.7), (2.8e-3, 0.3)]), jitter: 2.0e-4)],
    stop: [Out(550)], END
    wall_bands: [(walls: "sides", low: 0.03, high: 0.07, bins: 1, sample: 0.005, average: 0.05), ],
)"""
# Name, scene, softness of the reference, softer ones.
CASES = (
    ("plane, linear, flat floor", FLAT, 1, (30, 100)),
    ("plane, linear, wedge of low friction", WEDGE, 1, (30, 100)),
    ("space, Hertz, slot", SLOT, 1, (100, 1000)),
    ("space, Hertz, cylinder", CYLINDER, 1, (300, 1000)),
    ("space, linear, cone, two sizes", CONE, 3, (300, 600)),
)
FIGURES = ("rate", "height", "load", "moving", "rest")


def call(siloflow, scene, out, *settings):
    """Runs a scene into a directory."""
    words = [siloflow, "run", scene, "--out", out, "--force", "--quiet", *settings]
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{done.args} failed:\n{done.stderr}")


def run(siloflow, scene, folder, soft, growth, seed):
    """Returns the figures of a run, and its mean overlap at rest over the radius."""
    out = folder / "run"
    call(siloflow, scene, out, "--set", f"parameters.soft={soft}", "--set", f"growth={growth}", "--seed", seed)
    return figures_of(out)


def figures_of(out):
    """Reads the figures of a run, and its mean overlap at rest over the radius."""
    summary = json.loads((out / "summary.json").read_text())
    rest = summary["rest_time_s"]
    if rest is None or summary["discharge"] is None:
        return None, None
    with open(out / "series.csv", encoding="utf-8") as file:
        last = [row for row in csv.DictReader(file) if float(row["time_s"]) <= rest][-1]
    with open(out / "wall_bands.csv", encoding="utf-8") as file:
        bands = list(csv.DictReader(file))
    pressure = next(name for name in bands[0] if name.startswith("pressure"))
    at_rest = [float(row[pressure]) for row in bands if float(row["to_s"]) <= rest]
    moving = [float(row[pressure]) for row in bands if float(row["from_s"]) > rest + 0.05]
    figures = {
        "rate": summary["discharge"]["rate_per_s"],
        "height": float(last["potential_j"]),
        "load": at_rest[-1] if at_rest else None,
        "moving": statistics.mean(moving) if moving else None,
        "rest": rest,
    }
    return figures, float(last["mean_overlap_ratio"])


def average(found):
    """Returns the mean of each figure over runs, its standard error, and the number of runs that have it."""
    means = {}
    for name in FIGURES:
        values = [figures[name] for figures in found if figures and figures[name] is not None]
        if len(values) > 1:
            means[name] = (statistics.mean(values), statistics.stdev(values) / len(values) ** 0.5, len(values))
    return means


def measure(siloflow, scene, folder, soft, growth, runs):
    """Returns the means of the figures and their standard errors."""
    return average([run(siloflow, scene, folder, soft, growth, seed)[0] for seed in range(1, runs + 1)])


def changes(found, base, runs):
    """Returns the cells of a row: the change of each figure from the reference in per cent, with its standard error."""
    cells = []
    for figure in FIGURES:
        (mean, error, count), (own, own_error, _) = found[figure], base[figure]
        both = (error**2 + own_error**2) ** 0.5
        missing = f" ({count} runs)" if count < runs else ""
        cells.append(f"{100 * (mean / own - 1):+.1f} ± {100 * both / abs(own):.1f}{missing}")
    return " | ".join(cells)


def options(doc, runs):
    """Reads the command line of a script about these silos."""
    parser = argparse.ArgumentParser(description=doc.split("\n")[0])
    parser.add_argument("--runs", type=int, default=runs)
    parser.add_argument("--only", nargs="*", help="names of silos, or parts of them")
    parser.add_argument("--siloflow", default=ROOT / "target/release/siloflow", type=pathlib.Path)
    arguments = parser.parse_args()
    arguments.siloflow = arguments.siloflow.resolve()
    if not arguments.siloflow.exists():
        sys.exit(f"{arguments.siloflow} is missing: run `cargo build --release`")
    return arguments


def chosen(arguments):
    """Returns the silos that the command line asks for, with whole scenes."""
    cases = ((name, text.replace("END", END), reference, softer) for name, text, reference, softer in CASES)
    return [case for case in cases if not arguments.only or any(part in case[0] for part in arguments.only)]


def main():
    arguments = options(__doc__, 16)
    siloflow = arguments.siloflow
    print("| silo | softness | growth | " + " | ".join(FIGURES) + " |\n|" + "---|" * (3 + len(FIGURES)))
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        scene = folder / "silo.ron"
        for name, text, reference, softer in chosen(arguments):
            scene.write_text(text)
            overlap = run(siloflow, scene, folder, reference, 0.0, 1)[1]
            base = measure(siloflow, scene, folder, reference, 0.0, arguments.runs)
            for soft in softer:
                growth = 0.5 * (run(siloflow, scene, folder, soft, 0.0, 1)[1] - overlap)
                for grown in (0.0, round(growth, 5)):
                    found = measure(siloflow, scene, folder, soft, grown, arguments.runs)
                    print(f"| {name} | {soft / reference:g} | {grown:g} | {changes(found, base, arguments.runs)} |", flush=True)


if __name__ == "__main__":
    main()
