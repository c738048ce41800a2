#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Tests examples/rigs/*.py on made-up copies of the repositories that they convert: results and errors.

usage: tests/examples/rigs_test.py
"""
import csv
import importlib.util
import math
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest
import zipfile

SCRIPTS = pathlib.Path(__file__).resolve().parent.parent.parent / "examples/rigs"


class Rigs(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.checkout, self.out = pathlib.Path(scratch.name, "checkout"), pathlib.Path(scratch.name, "out")
        self.checkout.mkdir()

    def file(self, path, text):
        file = self.checkout / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def run_script(self, name):
        return subprocess.run([sys.executable, SCRIPTS / name, self.checkout, self.out], capture_output=True, text=True)

    def converted(self, name):
        """Returns the converted logs: {file name: rows}."""
        said = self.run_script(name)
        self.assertEqual(said.returncode, 0, said.stderr)
        logs = {}
        for file in sorted(self.out.iterdir()):
            with open(file, newline="") as text:
                logs[file.name] = list(csv.DictReader(text))
        return logs

    def test_every_script_refuses_an_empty_checkout(self):
        for name in ("qube.py", "double_pendulum.py", "battery.py", "car.py"):
            said = self.run_script(name)
            self.assertEqual(said.returncode, 1, name)
            self.assertIn(f"{name}: error: ", said.stderr)

    def test_the_qube_log_is_extracted_unchanged(self):
        log = "id,alpha,theta,alpha_dot,theta_dot,time\n0,-0.7,-0.04,-3.4,-1.0,3.62\n1,-0.8,-0.05,-3.5,-1.1,3.63\n"
        (self.checkout / "Data").mkdir()
        with zipfile.ZipFile(self.checkout / "Data/QQS2_data_diffx0.zip", "w") as archive:
            archive.writestr("QQS2_data_diffx0/example_csv_fin3.csv", log)
            archive.writestr("QQS2_data_diffx0/notes.csv", "a\n1\n")
        self.converted("qube.py")
        self.assertEqual([f.name for f in self.out.iterdir()], ["example_csv_fin3.csv"])
        self.assertEqual((self.out / "example_csv_fin3.csv").read_text(), log)

    def test_the_error_names_a_cell_that_is_not_a_number(self):
        self.file("data/experiment_records/design_C.0/20220914/sys_id/trajectory_00.csv",
                  "time,pos_meas1,pos_meas2,tau_meas1,tau_meas2\n0,0,0,0,0\n0.002,0,nothing,0,0\n")
        said = self.run_script("double_pendulum.py")
        self.assertEqual(said.returncode, 1)
        self.assertIn("trajectory_00.csv:3: 'pos_meas2' is not a number", said.stderr)

    def test_only_the_drive_cycles_of_the_battery_are_converted(self):
        heading = "Time [s],Voltage [V],Current [A],Temperature [degC],Capacity [Ah],SOC [-]\n"
        for cycle in ("551_Mixed1", "551_US06", "551_Charge1", "549_HPPC"):
            self.file(f"dataset/LG_HG2_processed/25degC/{cycle}_processed.csv", heading + "1,4.18,-0.5,25,-0.1,0.97\n")
        logs = self.converted("battery.py")
        self.assertEqual(list(logs), ["25degC_Mixed1.csv", "25degC_US06.csv"])
        row = logs["25degC_US06.csv"][0]
        self.assertEqual((float(row["current"]), float(row["charge"]), float(row["soc"])), (-0.5, -0.1, 0.97))

    def test_a_car_on_a_circle_has_its_known_speeds(self):
        radius, rate, slip, frames = 1.5, 1.2, 0.05, 4000
        draw = random.Random(1)
        text = ("elapsed time sensors,current,voltage,acc x (IMU),acc y (IMU),W (IMU),vel encoder,safety_value,throttle,"
                "steering,vicon time,vicon x,vicon y,vicon yaw\n")
        for k in range(frames):
            t = 0.01 * k + draw.uniform(-3e-4, 3e-4)
            angle = rate * t
            yaw = math.remainder(angle + math.pi / 2 + slip, 2 * math.pi)  # wraps
            text += (f"{2540 + 0.1 * (k // 10)},0,0,0.1,{0.01 * (k // 10)},{rate},1.8,0,0.3,0.4,{1725443977 + t!r},"
                     f"{radius * math.cos(angle)},{radius * math.sin(angle)},{yaw}\n")
        self.file("System_identification/Data/80_circles/car_1_Datarecording_a.csv", text)
        self.file("ROS_packages/racecar_pkg/src/Data/again/car_1_Datarecording_b.csv", text)  # a second recording with the same content
        logs = self.converted("car.py")
        self.assertEqual(len(logs), 1)
        rows = next(iter(logs.values()))
        self.assertEqual(len(rows), frames // 10)  # a row for each message
        for k, row in enumerate(rows):
            self.assertAlmostEqual(float(row["time"]), 0.1 * k, delta=1e-3)
            self.assertAlmostEqual(float(row["acc_y"]), 0.01 * k, delta=1e-9)
            at_an_end = k < 10 or k >= len(rows) - 10
            for name, value in (("v_x", radius * rate * math.cos(slip)), ("v_y", -radius * rate * math.sin(slip)),
                                ("r", rate)):
                self.assertAlmostEqual(float(row[name]), value, delta=0.1 if at_an_end else 1e-3)


@unittest.skipUnless(importlib.util.find_spec("numpy"), "unseen.py needs numpy")
class Unseen(unittest.TestCase):
    """Scores of examples/rigs/unseen.py on four readings, of which two are alike."""

    def setUp(self):
        import numpy
        self.np, spec = numpy, importlib.util.spec_from_file_location("unseen", SCRIPTS / "unseen.py")
        self.unseen = importlib.util.module_from_spec(spec)
        sys.dont_write_bytecode = True
        spec.loader.exec_module(self.unseen)
        a, b, c, noise = numpy.random.default_rng(1).normal(size=(4, 5000))
        self.training = [{"v": numpy.stack([a, a + .05 * noise, b, c], 1)}]
        self.apart = {"v": numpy.stack([a, b, c, noise], 1)}  # the first two are no longer alike
        self.wide = {"v": self.training[0]["v"] * [1, 1, 3, 1]}  # the third moves over a larger range

    def share(self, score, run):
        limit = self.np.quantile(score(self.training[0]), 0.99)
        return (score(run) > limit).mean()

    def test_least_variance_flags_readings_that_separate_but_not_wider_ones(self):
        score, cost = self.unseen.distance("v", self.training, 1)
        self.assertEqual(cost, 5)
        self.assertGreater(self.share(score, self.apart), 0.9)
        self.assertAlmostEqual(self.share(score, self.wide), 0.01, delta=0.005)  # control: false flags only

    def test_rows_flag_wider_readings_but_not_readings_that_separate(self):
        score, _ = self.unseen.distance("v", self.training, 1, over=self.wide["v"] * [1, 1, 1e3, 1])
        self.assertGreater(self.share(score, self.wide), 0.3)  # |normal| > 2.58 / 3: .39
        self.assertLess(self.share(score, self.apart), 0.1)  # above .01, because 5,000 samples correlate by chance


if __name__ == "__main__":
    unittest.main()
