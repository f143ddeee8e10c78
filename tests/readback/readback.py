"""Reads exported frames with the programs they are meant for, and compares the numbers at full precision.

    pip install -r tests/readback/requirements.txt -r tests/readback/optional.txt
    python tests/readback/readback.py target/release/siloflow [target/release/outside]

The second program is that of `examples/outside`: its behaviour has a column of grains, of the series, and a value. Files are read by
VTK (the reader of ParaView), ASE, OVITO and pandas. OVITO is left out where it is not installed, and Parquet where it or the feature of
siloflow is missing; the last line says so. What they read is compared

* with `state.csv` and `series.csv` of the run, which siloflow writes on another path: equal to the last bit, sums to rounding;
* with each other: all formats hold the same doubles. OVITO rounds a last bit, and keeps radii as floats of 4 bytes;
* with geometry: a contact line is as long as both radii less the overlap, and walls have the areas of the scene.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import ase.io
import numpy as np
import pandas
from vtk import vtkXMLPolyDataReader
from vtk.util.numpy_support import vtk_to_numpy
from xml.etree import ElementTree

try:
    from ovito.io import import_file
except ImportError:
    import_file = None
try:
    import pyarrow.parquet
except ImportError:
    pyarrow = None

ROOT = pathlib.Path(__file__).resolve().parents[2]

CONDUCTION = (
    'behaviours={"conduction": (temperatures: [400.0, 300.0], conductance: 200.0, heat_capacity: 800.0, interval: 0.5)}'
)

# Scene, settings, number of components of a vector, whether it needs the behaviour of examples/outside.
RUNS = [
    ("silo1-mixture.ron", ["spawner.count=60", "until=4.0", "data_frames=(interval: 1.0)"], 2, False),
    ("couette.ron", ["until=0.3", "data_frames=(interval: 0.1)"], 2, False),
    ("chute3d.ron", ["until=0.06", "data_frames=(interval: 0.02)"], 3, False),
    ("silo3d.ron", ["until=0.02", "data_frames=(interval: 0.01)", "door.opens=At(0.005)"], 3, False),
    ("chute3d.ron", ["until=0.004", "series.interval=0.002", "data_frames=(interval: 0.002)", CONDUCTION], 3, True),
]


def check(condition, *words):
    if not condition:
        raise SystemExit(" ".join(str(word) for word in ("readback:", *words)))


def same(a, b, *words):
    """Both arrays have the same bits."""
    a, b = np.asarray(a), np.asarray(b)
    check(a.shape == b.shape, *words, "shapes", a.shape, b.shape)
    check(np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), *words, "differ by up to", np.max(np.abs(a.astype(float) - b.astype(float)), initial=0.0))


def near(a, b, *words):
    """Numbers differ by a last bit at most: OVITO's reader of text rounds so. Whole numbers are equal."""
    a, b = np.asarray(a), np.asarray(b)
    if b.dtype.kind != "f":
        return same(a, b, *words)
    check(a.shape == b.shape, *words, "shapes", a.shape, b.shape)
    is_near = (np.abs(a - b) <= np.spacing(np.abs(b))) | (np.isnan(a) & np.isnan(b))
    check(is_near.all(), *words, "differ by up to", np.nanmax(np.abs(a - b), initial=0.0))


def run(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
    check(done.returncode == 0, *arguments, done.stderr)
    return done.stdout


def read_vtp(path):
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    check(reader.GetErrorCode() == 0, path)
    data = reader.GetOutput()
    arrays = [
        {of.GetArrayName(i): vtk_to_numpy(of.GetArray(i)) for i in range(of.GetNumberOfArrays())}
        for of in (data.GetPointData(), data.GetCellData())
    ]
    time = data.GetFieldData().GetArray("TimeValue").GetValue(0)
    points = vtk_to_numpy(data.GetPoints().GetData()) if data.GetNumberOfPoints() else np.zeros((0, 3))
    return data, points, *arrays, time


def read_pvd(path):
    sets = ElementTree.parse(path).getroot().find("Collection")
    return [(float(one.get("timestep")), path.parent / one.get("file")) for one in sets]


# Names that OVITO has for columns of the table `grains`.
OVITO_NAMES = {
    "id": "Particle Identifier", "mass": "Mass", "velocity": "Velocity", "force": "Force", "pressure": "pressure",
    "kind": "kind", "temperature": "temperature",
}


def compare_ovito(run_directory, place, columns, points, components):
    """A frame, as OVITO reads it."""
    for name in ("frames.xyz", "frames.dump"):
        path = run_directory / name
        particles = import_file(str(path)).compute(place).particles
        near(particles.identifiers[...], columns["id"], path, "ids of OVITO")
        near(particles.positions[...], points, path, "positions of OVITO")
        near(particles["Radius"][...], columns["radius"].astype(np.float32), path, "radii of OVITO")
        first = 1 if name == "frames.dump" else 0
        near(particles.particle_types[...], columns["species"].astype(int) + first, path, "types of OVITO")
        for own, other in OVITO_NAMES.items():
            if own in columns:
                values = particles[other][...]
                expected = columns[own] if values.ndim == 1 else columns[own][:, :3]
                near(values, expected, path, own, "of OVITO")


def compare_tables(program, run_directory, place, columns, points, components):
    """A frame in CSV and Parquet tables."""
    tables = {"csv": pandas.read_csv(run_directory / "csv/grains.csv")}
    if has_parquet(program):
        tables["parquet"] = pandas.read_parquet(run_directory / "parquet/grains.parquet")
    for format, table in tables.items():
        frames = [frame for _, frame in table.groupby("step", sort=False)]
        frame = frames[place]
        for axis, name in enumerate("xyz"[:components]):
            same(frame[f"position_{name}"], points[:, axis], format, "position")
            same(frame[f"velocity_{name}"], columns["velocity"][:, axis], format, "velocity")
            same(frame[f"force_{name}"], columns["force"][:, axis], format, "force")
        for name, values in columns.items():
            if values.ndim == 1:
                same(frame[name], values, format, name)
        check(set(columns) >= {"id", "kinetic_energy"}, "columns", set(columns))
    return tables


def compare_files_of_tables(program, run_directory):
    """Every CSV file of a run, and every exported one, against its Parquet file."""
    if not has_parquet(program):
        return
    pairs = [(path, path.stem) for path in run_directory.glob("*.csv") if not path.stem.startswith("input-")]
    pairs += [(path, path.stem) for path in (run_directory / "csv").glob("*.csv")]
    check({"grains", "contacts", "wall_contacts", "series", "state"} <= {name for _, name in pairs}, "tables", pairs)
    for path, name in pairs:
        table, expected = pandas.read_parquet(run_directory / f"parquet/{name}.parquet"), pandas.read_csv(path)
        check(list(table.columns) == list(expected.columns), path, "columns", list(table.columns))
        for column in table.columns:
            if expected[column].dtype.kind in "if":
                same(table[column], expected[column], path, column)
            else:
                check(list(table[column]) == list(expected[column]), path, column)
    units = pyarrow.parquet.read_schema(run_directory / "parquet/grains.parquet").metadata
    check(units[b"unit:velocity_x"] == b"m/s" and units[b"unit:time_s"] == b"s", "units", units)


def has_parquet(program):
    if program not in HAS_PARQUET:
        asked = subprocess.run([program, "export", "nowhere", "--to", "parquet"], capture_output=True, text=True, check=False)
        HAS_PARQUET[program] = pyarrow is not None and "export::feature" not in asked.stderr
    return HAS_PARQUET[program]


HAS_PARQUET = {}


def compare_run(program, run_directory, components):
    for format in ("vtk", "extxyz", "dump", "csv") + (("parquet",) if has_parquet(program) else ()):
        run(program, "export", run_directory, "--to", format)
    again = subprocess.run([program, "export", run_directory, "--to", "vtk"], capture_output=True, check=False)
    check(again.returncode == 2, "an existing target is not refused")
    grains = read_pvd(run_directory / "vtk/grains.pvd")
    xyz = ase.io.read(run_directory / "frames.xyz", index=":", format="extxyz")
    dump = ase.io.read(run_directory / "frames.dump", index=":", format="lammps-dump-text")
    check(len(grains) == len(xyz) == len(dump) >= 3, "numbers of frames", len(grains), len(xyz), len(dump))
    axes = "xyz"[:components]
    series = pandas.read_csv(run_directory / "series.csv")
    for place, ((time, path), atoms, atoms_of_dump) in enumerate(zip(grains, xyz, dump)):
        data, points, columns, _, own_time = read_vtp(path)
        if import_file:
            compare_ovito(run_directory, place, columns, points, components)
        compare_tables(program, run_directory, place, columns, points, components)
        check(time == own_time == atoms.info["Time"], "times", time, own_time, atoms.info["Time"])
        check(data.GetNumberOfVerts() == len(points) == len(atoms) == len(atoms_of_dump), path, "has points without cells")
        for name, of_xyz in [
            ("id", "id"), ("species", "type"), ("kind", "kind"), ("radius", "radius"), ("mass", "mass"),
            ("pressure", "pressure"), ("coordination", "coordination"), ("kinetic_energy", "kinetic_energy"),
        ]:
            same(columns[name], atoms.arrays[of_xyz], path, name)
        same(points, atoms.positions, path, "positions of extended XYZ")
        # ASE sorts the rows of a dump by id.
        same(points[np.argsort(columns["id"])], atoms_of_dump.positions, path, "positions of the dump")
        same(columns["velocity"][:, :components], atoms.arrays["velo"], path, "velocity")
        same(columns["force"][:, :components], atoms.arrays["force"], path, "force")
        check(not columns["velocity"][:, components:].any(), path, "velocities have a z")
        row = series[np.isclose(series["time_s"], time, rtol=0, atol=1e-9)]
        check(len(row) == 1, "rows of series.csv at", time)
        kinetic = columns["kinetic_energy"].sum()
        # Sums in another order: at most as many roundings as grains.
        check(abs(kinetic - row["kinetic_j"].iloc[0]) <= 1e-12 * max(kinetic, 1e-300), "kinetic energy", kinetic, row["kinetic_j"])
        if "temperature" in columns:
            same(columns["temperature"], atoms.arrays["temperature"], path, "temperature")
            # ASE leaves further columns of a dump out; OVITO reads them.
            compare_heat(columns, row)
    compare_files_of_tables(program, run_directory)
    # The last frame is the final state.
    state = pandas.read_csv(run_directory / "state.csv")
    own = columns["kind"] == 0
    same(columns["id"][own], state["id"], "ids")
    same(points[own][:, :components], state[list(axes)], "positions of state.csv")
    same(columns["velocity"][own][:, :components], state[["v" + axis for axis in axes]], "velocities of state.csv")
    same(columns["radius"][own], state["radius"], "radii of state.csv")
    if "wz" in state:
        spins = state[["wx", "wy", "wz"]] if components == 3 else np.c_[0 * state["wz"], 0 * state["wz"], state["wz"]]
        same(columns["spin"][own], spins, "spins of state.csv")
    contacts = compare_contacts(run_directory, points, columns, components)
    return len(grains), len(points), contacts


def compare_heat(columns, row):
    """Temperatures of a frame against the row of the series at its time, computed by another system."""
    temperatures, is_grain = columns["temperature"], columns["kind"] == 0
    check(np.isnan(temperatures[~is_grain]).all(), "wall grains have a temperature")
    # A grain that has just been released gets its temperature one step later.
    known = np.isfinite(temperatures)
    check(known.sum() >= is_grain.sum() - 1, "grains without a temperature")
    heat = 800.0 * (columns["mass"] * temperatures)[known].sum()
    check(abs(heat / row["heat_j"].iloc[0] - 1.0) < 1e-13, "heat", heat, row["heat_j"].iloc[0])
    mean = heat / (800.0 * columns["mass"][known].sum())
    check(abs(mean / row["mean_temperature_k"].iloc[0] - 1.0) < 1e-13, "mean temperature", mean)
    check(temperatures[known].min() >= 300.0 and temperatures[known].max() <= 400.0, "temperatures")


def compare_contacts(run_directory, points, columns, components):
    """Contacts and walls of the last frame."""
    _, path = read_pvd(run_directory / "vtk/contacts.pvd")[-1]
    data, ends, _, contacts, _ = read_vtp(path)
    count = len(contacts["grain"])
    check(data.GetNumberOfLines() == count and len(ends) == 2 * count, path, "numbers of lines")
    row_of = {grain: row for row, grain in enumerate(columns["id"])}
    coordination = np.zeros(len(points), dtype=int)
    for place in range(count):
        row = row_of[contacts["grain"][place]]
        same(ends[2 * place], points[row], "a contact begins at its grain")
        coordination[row] += 1
        length = np.linalg.norm(ends[2 * place + 1] - ends[2 * place])
        reach = columns["radius"][row]
        if not contacts["with_wall"][place]:
            partner = row_of[contacts["partner"][place]]
            coordination[partner] += 1
            reach += columns["radius"][partner]
        # Positions of up to 4 m have an error of 4e-16 m.
        check(abs(reach - contacts["overlap"][place] - length) < 4e-15, path, "length of a contact", length)
    same(coordination, columns["coordination"], "coordination numbers")
    walls = run_directory / "vtk/walls.pvd"
    if walls.exists():
        _, path = read_pvd(walls)[-1]
        data, corners, _, cells, _ = read_vtp(path)
        check(data.GetNumberOfCells() == len(cells["wall"]), path, "numbers of cells")
        if "temperature" not in columns and components == 3 and "silo3d" in str(run_directory):
            # The hopper has four half-spaces and two inclined panels; the door has gone.
            check(sorted(set(cells["wall"])) == [1, 2, 3, 4, 5, 6] and not cells["door"].any(), "walls", set(cells["wall"]))
            areas = {wall: 0.0 for wall in set(cells["wall"])}
            for cell, wall in enumerate(cells["wall"]):
                a, b, c = (np.array(data.GetPoint(data.GetCell(cell).GetPointId(corner))) for corner in range(3))
                areas[wall] += 0.5 * np.linalg.norm(np.cross(b - a, c - a))
            for panel in (5, 6):
                check(abs(areas[panel] - 0.06 * np.hypot(0.076, 0.076)) < 1e-12, "area of a panel", areas[panel])
    return count


def main():
    programs = [pathlib.Path(argument).resolve() for argument in sys.argv[1:]]
    with tempfile.TemporaryDirectory() as here:
        for place, (scene, settings, components, with_behaviour) in enumerate(RUNS):
            if with_behaviour and len(programs) < 2:
                print("no column of a behaviour: give the program of examples/outside too")
                continue
            program = programs[1 if with_behaviour else 0]
            directory = pathlib.Path(here) / f"{place}-{scene.removesuffix('.ron')}"
            set_all = [word for setting in settings for word in ("--set", setting)]
            run(program, "run", ROOT / "scenes" / scene, "--quiet", "--out", directory, *set_all)
            frames, grains, contacts = compare_run(program, directory, components)
            print(f"{scene}: {frames} frames, {grains} particles and {contacts} contacts in the last one: all equal")
            summary = json.loads((directory / "summary.json").read_text())
            check(summary["grains"]["lost"] == 0, scene, "lost grains")
            if with_behaviour:
                value = summary["behaviours"]["conduction"]["heat"]
                series = pandas.read_csv(directory / "series.csv")
                check(value["unit"] == "J" and value["value"] == series["heat_j"].iloc[-1], "heat in the summary", value)
    left_out = [] if import_file else ["OVITO is not installed (pip install ovito)"]
    if pyarrow is None:
        left_out.append("pyarrow is not installed")
    left_out += [f"{program.name} was built without `--features parquet`" for program in programs if not has_parquet(program)]
    print("left out:", "; ".join(left_out) or "nothing")


main()
