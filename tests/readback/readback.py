"""Reads exported frames with the programs they are meant for, and compares the numbers at full precision.

    pip install -r tests/readback/requirements.txt
    python tests/readback/readback.py target/release/siloflow

Files are read by VTK (the reader of ParaView), ASE and pandas. What they read is compared

* with `state.csv` and `series.csv` of the run, which siloflow writes on another path: equal to the last bit, sums to rounding;
* with each other: the three formats hold the same doubles;
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

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Scene, settings, number of components of a vector.
RUNS = [
    ("silo1-mixture.ron", ["spawner.count=60", "until=4.0", "data_frames=(interval: 1.0)"], 2),
    ("couette.ron", ["until=0.3", "data_frames=(interval: 0.1)"], 2),
    ("chute3d.ron", ["until=0.06", "data_frames=(interval: 0.02)"], 3),
    ("silo3d.ron", ["until=0.02", "data_frames=(interval: 0.01)", "door.opens=At(0.005)"], 3),
]


def check(condition, *words):
    if not condition:
        raise SystemExit(" ".join(str(word) for word in ("readback:", *words)))


def same(a, b, *words):
    """Both arrays have the same bits."""
    a, b = np.asarray(a), np.asarray(b)
    check(a.shape == b.shape, *words, "shapes", a.shape, b.shape)
    check(np.array_equal(a, b), *words, "differ by up to", np.max(np.abs(a.astype(float) - b.astype(float)), initial=0.0))


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


def compare_run(program, run_directory, components):
    for format in ("vtk", "extxyz", "dump"):
        run(program, "export", run_directory, "--to", format)
    again = subprocess.run([program, "export", run_directory, "--to", "vtk"], capture_output=True, check=False)
    check(again.returncode == 2, "an existing target is not refused")
    grains = read_pvd(run_directory / "vtk/grains.pvd")
    xyz = ase.io.read(run_directory / "frames.xyz", index=":", format="extxyz")
    dump = ase.io.read(run_directory / "frames.dump", index=":", format="lammps-dump-text")
    check(len(grains) == len(xyz) == len(dump) >= 3, "numbers of frames", len(grains), len(xyz), len(dump))
    axes = "xyz"[:components]
    series = pandas.read_csv(run_directory / "series.csv")
    for (time, path), atoms, atoms_of_dump in zip(grains, xyz, dump):
        data, points, columns, _, own_time = read_vtp(path)
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
        if components == 3 and "silo3d" in str(run_directory):
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
    program = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as here:
        for scene, settings, components in RUNS:
            directory = pathlib.Path(here) / scene.removesuffix(".ron")
            set_all = [word for setting in settings for word in ("--set", setting)]
            run(program, "run", ROOT / "scenes" / scene, "--quiet", "--out", directory, *set_all)
            frames, grains, contacts = compare_run(program, directory, components)
            print(f"{scene}: {frames} frames, {grains} particles and {contacts} contacts in the last one: all equal")
            summary = json.loads((directory / "summary.json").read_text())
            check(summary["grains"]["lost"] == 0, scene, "lost grains")


main()
