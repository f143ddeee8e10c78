"""Tests of the package as it is installed. They run in a directory of their own and need no other package: python -m unittest."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import numpy as np
import pandas as pd

import siloflow
from siloflow._settings import settings

# Four elastic discs fall 1 m onto a floor.
SCENE = """(
    seed: 1,
    gravity: (0.0, -9.81),
    contact: Linear(k: 1.0e5, damping: Restitution(0.8)),
    mass: ArealSquare(100.0),
    step: Fixed(1.0e-4),
    walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))],
    fill: [(low: (0.0, 1.0), high: (0.8, 1.2), spacing: 0.2, radius: Fixed(0.04))],
    until: 0.2,
    pictures: None,
    data_frames: (interval: 0.05),
)"""


class InADirectory(unittest.TestCase):
    def setUp(self):
        self.before = os.getcwd()
        self.here = tempfile.TemporaryDirectory()
        os.chdir(self.here.name)
        Path("fall.ron").write_text(SCENE, encoding="utf-8")

    def tearDown(self):
        os.chdir(self.before)
        self.here.cleanup()


class Runs(InADirectory):
    def test_a_run_has_its_files_as_frames_and_arrays(self):
        run = siloflow.run("fall.ron")
        self.assertEqual(run.path, Path("out/fall"))
        self.assertEqual(run.summary["grains"]["released"], 4)
        self.assertEqual(run.summary["status"], "time_reached")
        # Four grains of 100 R^2 = 0.16 kg in free fall: the kinetic energy is m g^2 t^2/2, exact for Verlet.
        series = run.series
        kinetic = 4 * 0.16 * 0.5 * (9.81 * series["time_s"]) ** 2
        np.testing.assert_allclose(series["kinetic_j"], kinetic, rtol=1e-10, atol=1e-12)
        self.assertEqual(len(run["state"]), 4)
        self.assertIn("series", run.tables)
        with self.assertRaisesRegex(KeyError, "no profiles.csv; it has .*series"):
            run["profiles"]

    def test_frames_have_the_numbers_of_the_state(self):
        run = siloflow.run("fall.ron")
        frames = list(run.frames())
        np.testing.assert_allclose([frame.time for frame in frames], [0.0, 0.05, 0.1, 0.15, 0.2], atol=1e-12)
        last = frames[-1]
        self.assertEqual((last.released, last.inside, last.out, last.lost), (4, 4, 0, 0))
        self.assertEqual(last.grains["position"].shape, (4, 2))
        # The tables of the end and of the last frame have the same doubles.
        by_id = last.frame().sort_values("id")
        state = run.state.sort_values("id")
        np.testing.assert_array_equal(by_id["position_y"].to_numpy(), state["y"].to_numpy())
        self.assertEqual(run.header()["dimension"], 2)

    def test_settings_are_those_of_the_command_line(self):
        run = siloflow.run("fall.ron", "out/other", until=0.1, contact__damping="B(0.0)", settings={"fill[0].count": 2})
        self.assertEqual(run.summary["grains"]["released"], 2)
        self.assertIn("count: 2", run.scene)
        direct = ["--quiet", "run", "fall.ron", "--out", "direct", "--set", "until=0.1", "--set", "contact.damping=B(0.0)"]
        subprocess.run([sys.executable, "-m", "siloflow", *direct, "--set", "fill[0].count=2"], check=True)
        self.assertEqual(run.summary["state_hash"], siloflow.Run("direct").summary["state_hash"])

    def test_wrong_input_is_named(self):
        with self.assertRaisesRegex(siloflow.SceneError, "unknown"):
            siloflow.run("fall.ron", untill=1.0)
        self.assertFalse(Path("out").exists())
        with self.assertRaises(siloflow.SceneError):
            siloflow.run("missing.ron")
        siloflow.run("fall.ron")
        with self.assertRaises(siloflow.SceneError):
            siloflow.run("fall.ron")
        siloflow.run("fall.ron", force=True)
        with self.assertRaisesRegex(FileNotFoundError, "no run directory"):
            siloflow.Run(".")

    def test_a_failure_has_its_run(self):
        with self.assertRaises(siloflow.RunFailed) as caught:
            # The discs hit the floor after 0.44 s and overlap with it by more than a millionth of their radius.
            siloflow.run("fall.ron", until=1.0, watchdog={"overlap": 1e-6})
        self.assertIn("overlap", str(caught.exception))
        self.assertEqual(caught.exception.run.summary["status"], "failed")

    def test_an_interrupted_program_leaves_a_run(self):
        long = ["--quiet", "run", "fall.ron", "--until", "1e6", "--set", "data_frames=None"]
        child = subprocess.Popen([sys.executable, "-m", "siloflow", *long])
        while not Path("out/fall/series.csv").is_file():
            self.assertIsNone(child.poll())
            time.sleep(0.01)
        child.send_signal(signal.SIGINT)
        self.assertEqual(child.wait(), 130)
        self.assertEqual(siloflow.Run("out/fall").summary["status"], "interrupted")


class Simulations(InADirectory):
    def test_a_stepped_simulation_is_the_run(self):
        simulation = siloflow.Simulation("fall.ron")
        start = simulation.position
        self.assertEqual((start.shape, simulation.steps, simulation.inside), ((4, 2), 0, 4))
        self.assertIsNone(simulation.advance(1000))
        self.assertEqual(simulation.steps, 1000)
        # Free fall from rest: Verlet is exact up to round-off.
        np.testing.assert_allclose(start[:, 1] - simulation.position[:, 1], 0.5 * 9.81 * 0.1**2, rtol=1e-11)
        np.testing.assert_allclose(simulation.velocity[:, 1], -0.981, rtol=1e-11)
        self.assertEqual(simulation.advance_to(5.0), "time_reached")
        state = siloflow.run("fall.ron").state.sort_values("id")
        np.testing.assert_array_equal(simulation.position[:, 1], state["y"].to_numpy())
        self.assertAlmostEqual(simulation.totals["kinetic"], 4 * 0.16 * 0.5 * (9.81 * 0.2) ** 2, delta=1e-10)
        self.assertEqual(list(simulation.frame().columns[:3]), ["id", "species", "radius"])

    def test_a_time_is_reached_by_its_step(self):
        simulation = siloflow.Simulation("fall.ron")
        simulation.advance_to(0.05)
        self.assertEqual(simulation.steps, 500)
        simulation.advance_to(0.05)
        self.assertEqual(simulation.steps, 500)

    def test_a_wrong_scene_is_named_with_its_place(self):
        Path("wrong.ron").write_text(SCENE.replace("0.04", "-0.04"), encoding="utf-8")
        with self.assertRaisesRegex(siloflow.SceneError, r"wrong.ron:8:\d+: .*(?s:.*)help: "):
            siloflow.Simulation("wrong.ron")


class Settings(unittest.TestCase):
    def test_python_and_numpy_values_become_ron(self):
        given = {"a[0].b": (1, 2.5), "c": [True, np.bool_(False)], "d": None, "e": {"f": np.int64(3), "g": np.float64(0.1)}, "h": "Fixed(0.1)"}
        self.assertEqual(dict(settings(given, {"i__j": 1e-9, "c": 4})), {
            "a[0].b": "(1, 2.5)", "c": "4", "d": "None", "e": "(f: 3, g: 0.1)", "h": "Fixed(0.1)", "i.j": "1e-09",
        })
        self.assertEqual(settings({"c": [True, np.bool_(False)]}, {}), [("c", "[true, false]")])


class Program(InADirectory):
    def test_the_command_is_installed(self):
        program = Path(sys.executable).parent / "siloflow"
        told = subprocess.run([program, "--version"], capture_output=True, encoding="utf-8", check=True).stdout
        self.assertEqual(told.strip(), f"siloflow {siloflow.__version__}")
        done = subprocess.run([program, "run", "fall.ron", "--json"], capture_output=True, encoding="utf-8", check=True)
        self.assertEqual(json.loads(done.stdout)["status"], "time_reached")

    def test_a_sweep_starts_the_program_for_each_run(self):
        plan = '(scene: "fall.ron", axes: [Values(key: "until", values: [0.1, 0.2])], seeds: 2, figures: ["time_s"])'
        Path("sweep.ron").write_text(plan, encoding="utf-8")
        subprocess.run([sys.executable, "-m", "siloflow", "--quiet", "sweep", "sweep.ron"], check=True)
        table = pd.read_csv("out/sweep/table.csv")
        np.testing.assert_allclose(table["mean"], [0.1, 0.2])
        self.assertEqual(list(table["n"]), [2, 2])


if __name__ == "__main__":
    unittest.main()
