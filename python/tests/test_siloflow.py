"""Tests of the package as it is installed. They run in a directory of their own and need no other package: python -m unittest."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

import numpy as np
import pandas as pd

import siloflow
from siloflow._ron import settings

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


# A heap of discs with friction between two walls, under a named lid that nothing touches.
HEAP = {
    "title": "a heap",
    "seed": 2,
    "gravity": (0.0, -9.81),
    "parameters": {"mu": 0.5},
    "mass": "Disc(100.0)",
    "step": "Fixed(1.0e-4)",
    "until": 0.4,
    "contact": siloflow.variant(
        "Linear", k=1e5, damping="Restitution(0.5)", tangential=siloflow.variant("Spring", k=1e5, damping="OfNormal(1.0)", friction='"=mu"')
    ),
    "walls": [
        siloflow.variant("HalfPlane", point=(0.0, 0.0), normal=(0.0, 1.0), name="floor"),
        siloflow.variant("HalfPlane", point=(-0.13, 0.0), normal=(1.0, 0.0)),
        siloflow.variant("HalfPlane", point=(0.13, 0.0), normal=(-1.0, 0.0)),
    ],
    "fill": [{"low": (-0.12, 0.0), "high": (0.12, 0.24), "spacing": 0.08, "jitter": 0.002, "radius": "Fixed(0.038)"}],
    "fields": [{"grid": siloflow.variant("XY", low=(-0.13, 0.0), high=(0.13, 0.26), cells=(1, 2)), "from": 0.0, "sample": 0.01}],
}


class Guests(InADirectory):
    """What a program does with a simulation: scenes as values, assignment, pushes, calls, threads, signals, files."""

    def heap(self, **keys):
        return siloflow.Simulation(HEAP, **keys)

    def test_scenes_are_files_text_and_dictionaries(self):
        of_file, of_text = siloflow.Simulation("fall.ron"), siloflow.Simulation(SCENE)
        for simulation in (of_file, of_text):
            simulation.advance_to(5.0)
        self.assertEqual(of_file.state_hash(), of_text.state_hash())
        self.assertEqual(siloflow.run(SCENE, "text").summary["state_hash"], of_text.state_hash())
        run = siloflow.run(HEAP, "heap", until=0.1)
        self.assertEqual((run.summary["grains"]["released"], run.summary["parameters"]), (9, {"mu": 0.5}))
        # Their files are there until the interpreter ends.
        program = f"import siloflow; siloflow.run({SCENE!r}, 'other')"
        with tempfile.TemporaryDirectory() as elsewhere:
            subprocess.run([sys.executable, "-c", program], check=True, cwd=elsewhere)
            self.assertEqual(sorted(os.listdir(elsewhere)), ["other"])
        with self.assertRaisesRegex(siloflow.SceneError, "untill: there is no such key(?s:.*)did you mean `until`"):
            siloflow.Simulation({**HEAP, "untill": 1.0})

    def test_the_state_is_assigned_and_its_energy_is_booked(self):
        simulation = self.heap()
        simulation.advance_to(0.25)
        before, error = simulation.position, simulation.figures["energy"]["balance_error"]
        with self.assertRaises(ValueError):
            before[0] = 0.0  # arrays are copies
        simulation.position = before + [0.0, 0.05]
        simulation.velocity = 0.0
        simulation.spin = 2.0
        np.testing.assert_array_equal(simulation.position, before + [0.0, 0.05])
        self.assertEqual(abs(simulation.velocity).max(), 0.0)
        np.testing.assert_array_equal(simulation.spin, 2.0)
        energy = simulation.totals
        total = sum(energy[kind] for kind in ("kinetic", "rotational", "potential", "elastic"))
        self.assertLess(abs(simulation.figures["energy"]["balance_error"] - error), 1e-12 * total)
        for wrong in (np.zeros((3, 2)), np.full((9, 2), np.nan)):
            with self.assertRaises(ValueError):
                simulation.velocity = wrong
        simulation.advance_to(1.0)
        self.assertEqual(simulation.status, "time_reached")

    def test_pushes_act_in_the_next_advance_alone(self):
        simulation = siloflow.Simulation("fall.ron")
        weight = simulation.mass[:, None] * [0.0, 9.81]
        simulation.add_force(weight)
        simulation.advance(100)
        slow = simulation.velocity[:, 1]
        # The kick of the first half step is by the weight alone.
        np.testing.assert_allclose(slow, -9.81 * 0.5e-4, rtol=1e-9)
        simulation.advance(100)
        np.testing.assert_allclose(simulation.velocity[:, 1] - slow, -9.81 * 0.995e-2, rtol=1e-9)
        with self.assertRaises(ValueError):
            simulation.add_force(np.inf)

    def test_calls_come_at_their_steps(self):
        simulation = siloflow.Simulation("fall.ron")
        seen = []
        call = simulation.every(30, lambda now: seen.append((now.steps, now.time)))
        simulation.advance(100)
        self.assertEqual([steps for steps, _ in seen], [30, 60, 90])
        simulation.forget(call)
        simulation.advance_to(9.0, progress=True)
        self.assertEqual((len(seen), simulation.status), (3, "time_reached"))

    def test_contacts_walls_fields_and_figures_are_those_of_the_state(self):
        simulation = self.heap()
        simulation.advance_to(0.4)
        contacts, walls, cells = simulation.contacts, simulation.walls, simulation.field()
        on_floor = contacts[(contacts.partner_kind == 2) & (contacts.partner == 1)]
        self.assertEqual(list(walls.name), ["floor", None, None])
        # The force on the floor is the sum over its contacts, whose drag has the velocities of the step's end and not those of the force pass.
        self.assertAlmostEqual(-walls.force_y[0] / on_floor.normal_force.sum(), 1.0, delta=1e-3)
        self.assertEqual(len(simulation.frame()), 9)
        self.assertEqual(set(simulation.grains), {"id", "species", "radius", "mass", "position", "velocity", "force", "spin"})
        with self.assertRaisesRegex(KeyError, "orientation"):
            simulation.orientation
        # All grains are in the two cells of 0.26 m x 0.13 m.
        self.assertAlmostEqual((cells.density * 0.26 * 0.13).sum() / simulation.mass.sum(), 1.0, delta=1e-12)
        with self.assertRaises(IndexError):
            simulation.field(1)
        figures = simulation.figures
        self.assertEqual((figures["status"], figures["grains"]["inside"]), ("time_reached", 9))
        self.assertEqual(figures["state_hash"], simulation.state_hash())
        self.assertIn("<svg", simulation._repr_html_())

    def test_a_saved_state_continues_to_the_same_bits(self):
        whole, part = self.heap(), self.heap()
        whole.advance_to(1.0)
        part.advance_to(0.1234)
        part.save("state")
        rest = self.heap(state="state")
        self.assertEqual((rest.steps, rest.state_hash()), (1234, part.state_hash()))
        rest.advance_to(1.0)
        self.assertEqual(rest.state_hash(), whole.state_hash())
        siloflow.run(HEAP, "heap")
        self.assertEqual(self.heap(state="heap").state_hash(), whole.state_hash())
        for wrong in ("missing", "heap/scene.ron"):
            with self.assertRaises(siloflow.SceneError):
                self.heap(state=wrong)
        with self.assertRaises(OSError):
            part.save("missing/state")

    def test_other_threads_run_and_use_in_two_threads_at_once_is_an_exception(self):
        simulation = self.heap(until=1e6)
        errors, turns = [], []
        done = threading.Event()

        def other():
            while not done.is_set():
                turns.append(time.monotonic())
                try:
                    simulation.advance(1)
                except RuntimeError as error:
                    errors.append(error)
                time.sleep(0.01)

        thread = threading.Thread(target=other)
        thread.start()
        while not errors:
            try:
                simulation.advance(10_000)
            except RuntimeError as error:
                errors.append(error)
        done.set()
        thread.join()
        # A thread that waits for the lock of Python gets it while the engine steps.
        self.assertLess(max(np.diff(turns), default=0.0), 1.0)
        simulation.advance(10)

    def test_an_interrupt_arrives_while_the_engine_steps(self):
        # Programs that a shell starts in the background ignore the interrupt, and so do their children.
        program = """if True:
            import signal, siloflow
            signal.signal(signal.SIGINT, signal.default_int_handler)
            simulation = siloflow.Simulation("fall.ron", until=1e6)
            print("go", flush=True)
            simulation.advance(10**12)
        """
        child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(child.stdout.readline(), b"go\n")
        time.sleep(0.5)
        start = time.monotonic()
        child.send_signal(signal.SIGINT)
        _, message = child.communicate(timeout=60.0)
        self.assertLess(time.monotonic() - start, 5.0)
        self.assertIn(b"KeyboardInterrupt", message)


class Studies(InADirectory):
    def test_a_run_is_shown_and_plotted(self):
        run = siloflow.run("fall.ron")
        self.assertIn("<svg", run.plot("energy")._repr_svg_())
        self.assertIn("<iframe srcdoc=", run._repr_html_())
        run.show().save("page.html")
        self.assertTrue(Path("page.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>"))
        with self.assertRaises(siloflow.SceneError):
            run.plot("nonsense")

    def test_a_sweep_is_a_table_and_an_estimate_has_an_interval(self):
        plan = '(scene: "fall.ron", axes: [Values(key: "until", values: [0.1, 0.2])], seeds: 2, figures: ["time_s"])'
        Path("plan.ron").write_text(plan, encoding="utf-8")
        np.testing.assert_allclose(siloflow.sweep("plan.ron")["mean"], [0.1, 0.2])
        found = siloflow.estimate("fall.ron", "grains.released", within="5%", budget="1min")
        self.assertIsNotNone(found.value)
        self.assertIn("grains.released", str(found))
        larger = siloflow.estimate("fall.ron", "time_s", within="5%", size={"until": 0.3}, out="larger")
        self.assertGreater(larger.record["size"]["change"], 0.0)
        # A scene that is no file is continued too.
        first, again = (siloflow.estimate(SCENE, "grains.released", within="5%", out="again") for _ in range(2))
        self.assertEqual(first.value, again.value)
        with self.assertRaises(siloflow.SceneError):
            siloflow.estimate("missing.ron", "grains.released", within="5%")


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
