#!/usr/bin/env python3
"""The same settled bed in LAMMPS and in siloflow: forces, coordination, nanoseconds per particle-step, ratio.

    apt-get install --no-install-recommends lammps
    cargo build --release
    docs/speed/side-by-side.py settle w1-1e4                 (makes the bed in LAMMPS: once, minutes for 1e5)
    docs/speed/side-by-side.py compare w1-1e4                (times both alternately, pinned to one core)
    docs/speed/side-by-side.py tile w1-1e5 10 --steps 200    (siloflow alone, ten such beds side by side)
    docs/speed/side-by-side.py shuffle w1-1e5                (siloflow alone, grains entering in random order)
    docs/speed/side-by-side.py threads w1-1e5 --threads 2    (siloflow alone, on one thread and on two alternately)
    docs/speed/side-by-side.py cores w1-1e4 --threads 2      (both, on one core and on two alternately; LAMMPS with MPI)

Beds: w1-1e3, w1-1e4, w1-1e5 (2D, frictionless, half R = 0.03 m and half 0.04 m) and w2-1e4, w2-1e5 (3D, friction with history).
All files are kept in --dir (default target/side-by-side). No packages needed.

LAMMPS's settled state becomes the grains file of a scene, with all its digits. Both programs then make one step from it.
The difference of their velocities, times m/dt, is the difference of their forces and must be round-off. (W2 uses mu = 1e4
in that step: no contact has a spring yet, and where the dashpot alone exceeds the cap, LAMMPS leaves out friction until
the spring has moved.)

Then both programs run the same number of steps alternately. The first 20 steps and set-up are left out: the time of LAMMPS
is the loop time of its second run, the time of siloflow is that of the whole run less that of a run of 20 steps. The
printed time is the median of the runs. Skins are those with which each program is fastest: --skin, --lammps-skin. siloflow
runs twice: with its energy balance, and with `energy_balance: false`, because LAMMPS keeps no energy balance.

The scheme of both programs is velocity Verlet (--integrator changes siloflow's).

The laws, in both: F_n = k delta - gamma m_eff v_n, which may pull, on flat walls with m_eff = m. W1: k = 1e5 N/m, e = 0.55 for
two grains of R = 0.04 m, m = 100 R^2, dt = 1e-4 s, g = 9.81 m/s2. W2: d = 1 mm, 2500 kg/m3, k = 2e5 m g/d, k_t = 2/7 k,
gamma_t = gamma/2, e = 0.55, mu = 0.5, periodic in x and y, dt = 1e-6 s.
"""

import argparse
import csv
import json
import math
import os
import pathlib
import random
import re
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
DECREMENT = -math.log(0.55)
HALF_LOG = 2.0 * DECREMENT / math.hypot(math.pi, DECREMENT)
D, M, G = 1.0e-3, math.pi / 6 * 1.0e-3**3 * 2500, 9.81
W1 = {"k": 1e5, "gamma": HALF_LOG * math.sqrt(1e5 / 0.08), "dt": 1e-4, "skin": 0.02, "lammps_skin": 0.01}
W2 = {"k": 2e5 * M * G / D, "dt": 1e-6, "skin": 0.02e-3, "lammps_skin": 0.05}
# Steps of LAMMPS's first run, in its input.
FIRST = 20
STICKING = 1.0e4  # the largest that LAMMPS takes
W2["gamma"] = HALF_LOG * math.sqrt(2 * W2["k"] / M)
BEDS = {
    "w1-1e3": {**W1, "grains": 1_000, "steps": 30_000, "settle": {"mix": 1}},
    "w1-1e4": {**W1, "grains": 10_000, "steps": 3000, "settle": {"mix": 1}},
    "w1-1e5": {**W1, "grains": 100_000, "steps": 400, "settle": {"mix": 1, "nset": 9000, "nset2": 4000}},
    "w2-1e4": {**W2, "grains": 10_000, "steps": 2000, "settle": {"L": 25}, "again": (16000, 8000, 2000)},
    "w2-1e5": {**W2, "grains": 100_000, "steps": 200, "settle": {"L": 50}, "again": (16000, 5000, 300)},
}


def is_planar(name):
    return name.startswith("w1")


def sh(command, **more):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **more)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def lammps(args, script, ranks=1, **variables):
    text = (HERE / script).read_text()
    words = [word for key, value in variables.items() for word in ("-var", key, value)]
    (args.dir / script).write_text(text)
    start = ["taskset", "-c", args.core] if ranks == 1 else ["mpirun", "--bind-to", "core", "-np", ranks]
    command = [*start, args.lmp, "-in", script, *words, "-log", "none"]
    root = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}  # containers
    return sh(command, cwd=args.dir, env={**os.environ, **root, "OMP_NUM_THREADS": "1"})


def settle(args, name):
    bed, data = BEDS[name], f"{name}.data"
    kind = name[:2]
    lammps(args, f"{kind}-settle.in", N=bed["grains"], out=data, **bed["settle"])
    if "again" in bed:
        lammps(args, "w2-resettle.in", data=data, **dict(zip(("n1", "n2", "n3"), bed["again"], strict=True)))
    elif bed["grains"] > 10_000:
        lammps(args, "w1-relax.in", data=data)
    print(f"{args.dir / data} written")


def read_data(path):
    """Box sides, and per atom (id, radius, mass, position, velocity, spin)."""
    lines = path.read_text().splitlines()
    box = {}
    for line in lines[:20]:
        words = line.split()
        if len(words) == 4 and words[2].endswith("lo"):
            box[words[2][0]] = (float(words[0]), float(words[1]))
    at = {line.split()[0]: number for number, line in enumerate(lines) if line[:5] in ("Atoms", "Veloc")}
    rows = {}
    for line in lines[at["Atoms"] + 2 :]:
        if not line.strip():
            break
        words = line.split()
        d, density = float(words[2]), float(words[3])
        # The same operations as in LAMMPS.
        r = 0.5 * d
        rows[int(words[0])] = [r, 4.0 * math.pi / 3.0 * r * r * r * density, [float(w) for w in words[4:7]]]
    for line in lines[at["Velocities"] + 2 :]:
        if not line.strip():
            break
        words = line.split()
        rows[int(words[0])].append([float(w) for w in words[1:7]])
    return box, rows


def write_grains(path, rows, planar, width, copies):
    """Writes a grains file. Copies differ in number and x only, so the other columns are formatted once."""
    atoms = []
    for atom in sorted(rows):
        r, m, x, v = rows[atom]
        rest = [x[1], v[0], v[1]] + ([] if planar else [x[2], v[2], *v[3:6]])
        atoms.append((atom, f"{r!r},{m!r},", x[0], "".join(f",{number!r}" for number in rest)))
    with path.open("w") as file:
        file.write("id,radius,mass,x,y,vx,vy" + ("\n" if planar else ",z,vz,wx,wy,wz\n"))
        for copy in range(copies):
            first, shift = copy * len(atoms) + 1, copy * width
            file.writelines(
                f"{atom if copies == 1 else first + place},{made}{x + shift!r}{rest}\n"
                for place, (atom, made, x, rest) in enumerate(atoms)
            )


def write_scene(args, name, copies=1):
    """The bed as scene and grains file, `copies` times side by side."""
    bed, planar = BEDS[name], is_planar(name)
    box, rows = read_data(args.dir / f"{name}.data")
    width = box["x"][1] - box["x"][0]
    stem = args.dir / (name if copies == 1 else f"{name}-x{copies}")
    write_grains(stem.with_suffix(".csv"), rows, planar, width, copies)
    law = f"k: {bed['k']!r}, damping: PerMass({bed['gamma']!r}), attraction: Allowed"
    if planar:
        floor = [f"HalfPlane(point: ({box['x'][0]!r}, 0.0), normal: (1.0, 0.0))",
                 f"HalfPlane(point: ({box['x'][0] + copies * width!r}, 0.0), normal: (-1.0, 0.0))",
                 "HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))"]
        space = f"gravity: (0.0, -{G}),"
    else:
        friction = f"Spring(k: {bed['k'] * 2 / 7!r}, damping: PerMass({bed['gamma'] / 2!r}), friction: 0.5)"
        law += f", tangential: {friction}"
        floor = ["HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))"]
        sides = ", ".join(f"{axis}: ({box[axis][0]!r}, {box[axis][1]!r})" for axis in "xy")
        space = f"space: Solid, gravity: (0.0, 0.0, -{G}), periodic: ({sides}),"
    stem.with_suffix(".ron").write_text(
        f"({space}\n contact: Linear({law}),\n walls: [{', '.join(floor)}],\n"
        f' grains: (file: "{stem.name}.csv"), integrator: {args.integrator}, step: Fixed({bed["dt"]}),\n'
        f" neighbours: VerletList(skin: {args.skin or bed['skin']}), pictures: None, series: (interval: 1.0e9),"
        f" until: 1.0,)\n")
    return stem.with_suffix(".ron"), rows


def siloflow(args, scene, dt, steps, *more):
    """One run: its summary."""
    out = args.dir / "out"
    command = ["taskset", "-c", args.core if args.threads == 1 else "0-63", args.siloflow, "run", scene, "--force", "--out", out,
               "--quiet", "--json", "--until", repr(steps * dt), "--threads", args.threads, *more]
    return json.loads(sh(command)), out


def nanoseconds(args, scene, dt, steps, *more):
    """Returns ns per particle-step after the first steps, and the summary of the whole run."""
    first, whole = (siloflow(args, scene, dt, count, *more)[0] for count in (FIRST, FIRST + steps))
    spent, done = (whole["performance"][key] - first["performance"][key] for key in ("wall_s", "particle_steps"))
    return 1e9 * spent / done, whole


def loop_time(text):
    """Returns ns per particle-step of LAMMPS's second run, and its last coordination number."""
    times = re.findall(r"Loop time of (\S+) on .* for (\d+) steps with (\d+) atoms", text)
    rows = re.findall(r"^ *\d+(?: +\S+)+ *$", text, re.M)
    seconds, steps, atoms = times[-1]
    return float(seconds) / int(steps) / int(atoms) * 1e9, float(rows[-1].split()[-1])


def forces_apart(args, name, scene, rows):
    """Returns the largest force difference, the rms force, and the rounding of velocities and positions as forces, N."""
    bed, planar = BEDS[name], is_planar(name)
    more = {} if planar else {"mu": STICKING}
    lammps(args, f"{name[:2]}-run.in", data=f"{name}.data", nsteps=0, first=1, dump="afterdump", **more)
    lines = (args.dir / "afterdump").read_text().splitlines()
    theirs = {int(line.split()[0]): [float(word) for word in line.split()[1:]] for line in lines[-len(rows):]}
    sticking = () if planar else ("--set", f"contact.tangential.friction={STICKING}")
    _, out = siloflow(args, scene, bed["dt"], 1, *sticking)
    axes = ("vx", "vy") if planar else ("vx", "vy", "vz")
    largest, squares, count = 0.0, 0.0, 0
    with (out / "state.csv").open() as file:
        for row in csv.DictReader(file):
            atom = int(row["id"])
            for axis, v in enumerate(axes):
                scale = rows[atom][1] / bed["dt"]
                largest = max(largest, abs(float(row[v]) - theirs[atom][axis]) * scale)
                squares += ((theirs[atom][axis] - rows[atom][3][axis]) * scale) ** 2
                count += 1
    speed = max(abs(v) for row in rows.values() for v in row[3][:3])
    heaviest = max(row[1] for row in rows.values())
    # Velocities carry a rounding of their own: as force, that is eps v m/dt.
    floor = 2.0**-52 * speed * heaviest / bed["dt"]
    # So do positions, which springs feel: a force that differs in its last digits rounds some of them to the next number.
    farthest = max(abs(x) for row in rows.values() for x in row[2])
    return largest, math.sqrt(squares / count), floor, 2.0**-52 * farthest * bed["k"]


def compare(args, name):
    bed = BEDS[name]
    scene, rows = write_scene(args, name)
    steps = args.steps or bed["steps"]
    largest, rms, of_velocities, of_positions = forces_apart(args, name, scene, rows)
    print(f"{name}: {len(rows)} grains, {steps} steps, {args.integrator}, core {args.core}")
    print(f"forces differ by at most {largest:.1e} N; rms force {rms:.1e} N; "
          f"rounding of velocities {of_velocities:.1e} N, of positions {of_positions:.1e} N")
    theirs, ways = [], {"siloflow": [], "  without energy balance": ["--set", "energy_balance=false"]}
    ours = {way: [] for way in ways}
    for _ in range(args.rounds):
        skin = args.lammps_skin or bed["lammps_skin"]
        ns, z_theirs = loop_time(lammps(args, f"{name[:2]}-run.in", data=f"{name}.data", nsteps=steps, skin=skin))
        theirs.append(ns)
        for way, settings in ways.items():
            ns, summary = nanoseconds(args, scene, bed["dt"], steps, *settings)
            ours[way].append(ns)
    reference = statistics.median(theirs)
    rows = [("LAMMPS", theirs, z_theirs, "walls excluded")]
    rows += [(way, times, summary["coordination"], "walls included") for way, times in ours.items()]
    for way, times, contacts, walls in rows:
        ns = statistics.median(times)
        print(f"{way:24} {ns:7.1f} ns per particle-step ({min(times):.1f} to {max(times):.1f}), {contacts:.3f} contacts per grain, "
              f"{walls}, ratio {reference / ns:.2f}")


def tile(args, name, copies):
    bed = BEDS[name]
    scene, _ = write_scene(args, name, copies)
    ns, summary = nanoseconds(args, scene, bed["dt"], args.steps or 2000)
    speed = {**summary["performance"], "ns": round(ns, 2)}
    print(json.dumps({"grains": summary["grains"]["released"] if "grains" in summary else None,
                      "coordination": summary["coordination"], **speed}))


def shuffle(args, name):
    """Times the bed unchanged and with its grains renumbered in random order, alternately: siloflow alone."""
    bed = BEDS[name]
    scene, _ = write_scene(args, name)
    header, *rows = scene.with_suffix(".csv").read_text().splitlines()
    random.Random(1).shuffle(rows)
    shuffled = args.dir / f"{name}-shuffled.ron"
    named = (f"{number},{row.split(',', 1)[1]}" for number, row in enumerate(rows))
    shuffled.with_suffix(".csv").write_text("\n".join([header, *named]) + "\n")
    shuffled.write_text(scene.read_text().replace(f"{name}.csv", f"{name}-shuffled.csv"))
    times = {scene: [], shuffled: []}
    for _ in range(args.rounds):
        for each, found in times.items():
            found.append(nanoseconds(args, each, bed["dt"], args.steps or bed["steps"])[0])
    for each, found in times.items():
        print(f"{each.stem:20} {statistics.median(found):7.1f} ns per particle-step ({min(found):.1f} to {max(found):.1f})")


def threads(args, name, most):
    """Times the bed on one thread and on `most`, alternately, and checks that the bits agree: siloflow alone."""
    bed = BEDS[name]
    scene, _ = write_scene(args, name)
    times, states = {1: [], most: []}, set()
    for _ in range(args.rounds):
        for args.threads, found in times.items():
            ns, summary = nanoseconds(args, scene, bed["dt"], args.steps or bed["steps"])
            found.append(ns)
            states.add(summary["state_hash"])
    if len(states) > 1:
        sys.exit(f"states differ: {states}")
    one = statistics.median(times[1])
    for count, found in times.items():
        ns = statistics.median(found)
        print(f"{name}, threads: {count} {ns:7.1f} ns per particle-step ({min(found):.1f} to {max(found):.1f}), {one / ns:.2f} times")


def cores(args, name, most):
    """Times both programs on one core and on `most`, alternately."""
    bed = BEDS[name]
    scene, _ = write_scene(args, name)
    steps, skin = args.steps or bed["steps"], args.lammps_skin or bed["lammps_skin"]
    times = {(program, count): [] for program in ("LAMMPS", "siloflow") for count in (1, most)}
    for _ in range(args.rounds):
        for (program, count), found in times.items():
            if program == "LAMMPS":
                ns, _ = loop_time(lammps(args, f"{name[:2]}-run.in", ranks=count, data=f"{name}.data", nsteps=steps, skin=skin))
            else:
                args.threads = count
                ns, _ = nanoseconds(args, scene, bed["dt"], steps)
            found.append(ns)
    middle = {way: statistics.median(found) for way, found in times.items()}
    for (program, count), found in times.items():
        ns = middle[program, count]
        print(f"{name}, {args.integrator}, cores: {count} {program:8} {ns:7.1f} ns per particle-step ({min(found):.1f} to {max(found):.1f}), "
              f"gain {middle[program, 1] / ns:.2f}, ratio {middle['LAMMPS', count] / ns:.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("settle", "compare", "tile", "shuffle", "threads", "cores", "scene"))
    parser.add_argument("bed", choices=BEDS)
    parser.add_argument("copies", nargs="?", type=int, default=1)
    parser.add_argument("--lmp", default="lmp")
    parser.add_argument("--siloflow", type=pathlib.Path, default=pathlib.Path("target/release/siloflow"))
    parser.add_argument("--dir", type=pathlib.Path, default=pathlib.Path("target/side-by-side"))
    parser.add_argument("--integrator", default="Verlet", help="the same as LAMMPS's; or Centred")
    parser.add_argument("--skin", type=float, help="m")
    parser.add_argument("--lammps-skin", type=float, help="m in W1, diameters in W2")
    parser.add_argument("--steps", type=int)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--core", default="0")
    parser.add_argument("--threads", type=int, default=1)
    args = parser.parse_args()
    args.dir = args.dir.resolve()
    args.dir.mkdir(parents=True, exist_ok=True)
    args.siloflow = args.siloflow.resolve()
    if args.what == "settle":
        settle(args, args.bed)
    elif args.what == "compare":
        compare(args, args.bed)
    elif args.what == "shuffle":
        shuffle(args, args.bed)
    elif args.what == "threads":
        threads(args, args.bed, max(args.threads, 2))
    elif args.what == "cores":
        cores(args, args.bed, max(args.threads, 2))
    elif args.what == "scene":
        print(write_scene(args, args.bed, args.copies)[0])
    else:
        tile(args, args.bed, args.copies)


if __name__ == "__main__":
    main()
