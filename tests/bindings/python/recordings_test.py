# SPDX-License-Identifier: MIT
"""MAT-files and bags of ROS 2 as tables and CSV logs; the files are written here."""
import contextlib
import io
import math
import os
import pathlib
import random
import sqlite3
import struct
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import numpy as np

import nlo
from nlo import bag, cdr, convert

try:
    import scipy.io
except ImportError:
    scipy = None

SAMPLES = 40
START, MS = 1_700_000_000_000_000_000, 1_000_000
RIG = ["t", "y(1)", "y(2)", "across(3)", "single", "counts", "rig.angle", "rig.inner.speed", "signals(2).values"]


class InAFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, name, data):
        (self.folder / name).write_bytes(data)
        return self.folder / name

    def refusal(self, function, *arguments):
        """Returns the error of a call, or an empty text."""
        try:
            function(*arguments)
        except nlo.Error as error:
            return str(error)
        return ""

    def assert_refused(self, what, function, *arguments):
        self.assertIn(what, self.refusal(function, *arguments))


class Cdr:
    """Serialises a message like ROS 2: each number at a multiple of its size."""

    def __init__(self, order="<"):
        self.order, self.data = order, b""

    def add(self, form, *values):
        for value in values:
            size = struct.calcsize(form)
            self.data += b"\0" * (-len(self.data) % size) + struct.pack(self.order + form, value)
        return self

    def text(self, text):
        self.add("I", len(text) + 1).data += text.encode() + b"\0"
        return self

    def array(self, form, values):
        return self.add("I", len(values)).add(form, *values)

    def header(self, stamp_ns, frame=""):
        return self.add("i", stamp_ns // 10**9).add("I", stamp_ns % 10**9).text(frame)

    def bytes(self):
        return bytes([0, self.order == "<", 0, 0]) + self.data


def imu(stamp_ns, x, order="<"):
    """Returns a sensor_msgs/Imu with acceleration (x, 2 x, 3 x) and rate (-x, -2 x, -3 x)."""
    message = Cdr(order).header(stamp_ns, "imu_link").add("d", 0, 0, 0, 1, *[7] * 9)
    return message.add("d", -x, -2 * x, -3 * x, *[7] * 9).add("d", x, 2 * x, 3 * x, *[7] * 9).bytes()


def float64(value):
    return Cdr().add("d", value).bytes()


class Messages(InAFolder):
    def setUp(self):
        super().setUp()
        self.types = cdr.Types()

    def number(self, of, path, data):
        return cdr.value(cdr.decode(self.types, of, data), cdr.steps_of(self.types, of, path))

    def test_numbers_after_texts_and_arrays_are_read_in_both_byte_orders(self):
        for order in "<>":
            data = imu(1_700_000_000_123_456_789, 0.1, order)
            for path, value in (("linear_acceleration.z", 0.1 * 3), ("angular_velocity.y", -0.2), ("orientation.w", 1),
                                ("angular_velocity_covariance[8]", 7), ("header.stamp.sec", 1_700_000_000),
                                ("header.stamp.nanosec", 123_456_789), ("header.stamp", 1_700_000_000_123_456_789)):
                self.assertEqual(self.number("sensor_msgs/msg/Imu", path, data), value, path)

    def test_joints_are_found_by_number_and_by_name(self):
        for names, positions in ((["wrist", "elbow"], [1.0, 2.0]), (["elbow", "wrist"], [2.0, 1.0])):
            message = Cdr().header(5).add("I", 2).text(names[0]).text(names[1])
            data = message.array("d", positions).array("d", []).array("d", []).bytes()
            self.assertEqual(self.number("sensor_msgs/JointState", "position[elbow]", data), 2)
            self.assertEqual(self.number("sensor_msgs/JointState", "position[0]", data), positions[0])
            for path in ("position[hand]", "velocity[elbow]", "position[2]"):
                self.assertTrue(math.isnan(self.number("sensor_msgs/JointState", path, data)), path)

    def test_definitions_may_have_constants_bounds_defaults_and_own_types(self):
        self.types.define("rig_msgs/msg/State", """# a rig
uint8 MODE_OFF=0
uint8 MODE_ON = 1   # a constant
string<=8 label
uint8 mode 1
float32[<=4] gains
Axis[2] axes
bool ok
================================================================================
MSG: rig_msgs/Axis
int16 counts
float64 angle 0.5
""")
        message = Cdr().text("abc").add("B", 1).array("f", [0.5, 0.25])
        data = message.add("h", -3).add("d", 1.5).add("h", 4).add("d", 2.5).add("B", 1).bytes()
        for path, value in (("mode", 1), ("gains[1]", 0.25), ("axes[1].counts", 4), ("axes[1].angle", 2.5), ("ok", 1)):
            self.assertEqual(self.number("rig_msgs/msg/State", path, data), value, path)
        decoded = cdr.decode(self.types, "rig_msgs/State", data)
        self.assertEqual(list(cdr.numbers_of(self.types, "rig_msgs/State", decoded)),
                         ["mode", "gains[0]", "gains[1]", "ok"])
        for path, what in (("axes[1].speed", "rig_msgs/Axis has no \"speed\", it has counts, angle"),
                           ("axes.angle", "is an array: write axes[0]"), ("mode[1]", "mode is not an array"),
                           ("label", "label is text"), ("axes[0]", "name one of its fields, counts, angle"),
                           ("mode.x", "mode is a uint8: it has no field x")):
            self.assert_refused(what, cdr.steps_of, self.types, "rig_msgs/State", path)
        for line in ("float64", "float64[x] y"):
            self.assert_refused("is not a field", self.types.define, "a/B", line)

    def test_a_message_that_ends_too_early_is_refused(self):
        whole = imu(1, 2.0)
        for length in range(len(whole)):
            self.assertRaises(nlo.Error, cdr.decode, self.types, "sensor_msgs/Imu", whole[:length])

    def test_decoding_terminates_for_any_bytes_and_definitions(self):
        self.types.define("a/Self", "a/Self inner\nfloat64 x\n")
        self.types.define("a/Many", "a/Self[] inner\nfloat64 x\n")
        self.types.define("a/Huge", "a/Empty[4000000000] inner\nfloat64 x\n")
        self.types.define("a/Empty", "")
        self.types.define("a/Unknown", "b/Nothing inner\nfloat64 x\n")
        for of in ("a/Self", "a/Many", "a/Huge", "a/Unknown"):
            self.assertRaises(nlo.Error, cdr.decode, self.types, of, bytes(4) + b"\xff" * 200)
        self.assert_refused("has a b/Nothing", cdr.decode, self.types, "a/Unknown", bytes(200))
        chance, data = random.Random(1), bytearray(imu(1, 2.0))
        for _ in range(2000):
            data[chance.randrange(len(data))] = chance.randrange(256)
            for of, path in (("sensor_msgs/Imu", "linear_acceleration.x"), ("sensor_msgs/JointState", "position[elbow]"),
                             ("std_msgs/Float64MultiArray", "data[1]")):
                self.refusal(self.number, of, path, bytes(data))


class Bag:
    """Writes a bag."""

    def __init__(self, path, definitions=()):
        self.database, self.topics = sqlite3.connect(path), 0
        self.database.executescript(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, offered_qos TEXT);"
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);"
            "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, encoding TEXT,"
            " encoded_message_definition TEXT, type_description_hash TEXT)")
        for name, text in definitions:
            self.database.execute("INSERT INTO message_definitions VALUES(NULL, ?, 'ros2msg', ?, '')", (name, text))

    def topic(self, name, of, form="cdr"):
        self.topics += 1
        self.database.execute("INSERT INTO topics VALUES(?, ?, ?, ?, '')", (self.topics, name, of, form))
        return self.topics

    def message(self, topic, time_ns, data):
        self.database.execute("INSERT INTO messages VALUES(NULL, ?, ?, ?)", (topic, time_ns, data))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.database.commit()
        self.database.close()


class Bags(InAFolder):
    def rig(self, name="rig.db3"):
        """Writes 50 messages of an IMU at 100 Hz, received 3 or 4 ms late, a truth at 40 Hz and a command at 10 Hz."""
        with Bag(self.folder / name) as written:
            imus = written.topic("/imu/data", "sensor_msgs/msg/Imu")
            truth = written.topic("/truth", "geometry_msgs/msg/TwistStamped")
            command = written.topic("/command", "std_msgs/msg/Float64")
            written.message(written.topic("/rosout", "rcl_interfaces/msg/Log"), START, b"whatever")
            for k in range(50):
                stamp = START + 10 * MS * k
                written.message(imus, stamp + 3 * MS + k % 2 * MS, imu(stamp, 0.5 * k))
            for k in range(21):
                twist = Cdr().header(START + 25 * MS * k, "map").add("d", *[10.0 * k] * 6)
                written.message(truth, START + 25 * MS * k + MS, twist.bytes())
            for k in range(5):
                written.message(command, START + 100 * MS * k + 35 * MS, float64(k))
        return self.folder / name

    def test_rows_follow_one_topic_and_other_topics_fill_cells_between(self):
        columns = ["/imu/data/linear_acceleration.y", "/truth/twist.linear.x", "/truth/twist.angular.z", "/command/data"]
        log = nlo.read_bag(self.rig(), columns, "/imu/data/header.stamp", {"/truth/twist.linear.x": 0})
        self.assertEqual(list(log), ["/imu/data/header.stamp", *columns])
        k = np.arange(50)
        np.testing.assert_allclose(log["/imu/data/header.stamp"], 0.01 * k, rtol=1e-15)
        np.testing.assert_array_equal(log[columns[0]], k)
        np.testing.assert_allclose(log[columns[1]], 4.0 * k, atol=1e-9)  # 10 per step of 25 ms, linear in between
        newest = 10 * k // 25
        is_new = np.diff(newest, prepend=-1) > 0
        np.testing.assert_array_equal(log[columns[2]], np.where(is_new, 10.0 * newest, np.nan))
        # received at 35 ms, before the stamp of 40 ms
        np.testing.assert_array_equal(log[columns[3]], np.where(k % 10 == 4, k // 10, np.nan))
        received = nlo.read_bag(self.rig("again.db3"), columns[:1], "/imu/data")
        self.assertAlmostEqual(received["/imu/data"][1], 0.011, delta=1e-12)

    def test_an_angle_is_interpolated_the_shorter_way_but_not_across_a_gap(self):
        with Bag(self.folder / "angle.db3") as written:
            rows, angle = (written.topic(name, "std_msgs/msg/Float64") for name in ("/rows", "/angle"))
            for k in range(100):
                written.message(rows, START + 10 * MS * k, float64(k))
            for ms, value in ((5, 3.0), (25, -3.0), (45, -2.9), (65, -2.8), (600, -2.8)):
                written.message(angle, START + ms * MS, float64(value))
        log = nlo.read_bag(self.folder / "angle.db3", ["/angle/data"], "/rows", {"/angle/data": 2 * math.pi})["/angle/data"]
        self.assertTrue(math.isnan(log[0]))
        self.assertAlmostEqual(log[1], 3 + 0.25 * (2 * math.pi - 6), delta=1e-12)
        self.assertAlmostEqual(log[3], -2.975, delta=1e-12)
        self.assertTrue(np.isnan(log[7:60]).all())
        self.assertEqual(log[60], -2.8)
        self.assertTrue(math.isnan(log[61]))

    def test_types_may_be_defined_in_the_bag(self):
        text = "std_msgs/Header header\nfloat32 torque\n====\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\n" \
               "string frame_id"
        with Bag(self.folder / "own.db3", [("rig_msgs/msg/Rig", text)]) as written:
            own = written.topic("/rig", "rig_msgs/msg/Rig")
            for k in range(3):
                written.message(own, START + k, Cdr().header(START + 10 * k, "x").add("f", 0.5 * k).bytes())
        log = nlo.read_bag(self.folder / "own.db3")
        self.assertEqual(list(log), ["/rig/header.stamp", "/rig/torque"])
        self.assertEqual(log["/rig/torque"][2], 1.0)

    def test_errors_name_file_topic_and_remedy(self):
        rig = self.rig()
        for columns, what in (
                (["/imu/dat/linear_acceleration.x"],
                 "rig.db3: no topic of \"/imu/dat/linear_acceleration.x\" among /imu/data, /truth, /command, /rosout"),
                (["/imu/data/linear_accel.x"], "did you mean \"linear_acceleration\"?"),
                (["/imu/data"], "/imu/data is a topic: name a number"),
                (["/rosout/level"], "type rcl_interfaces/msg/Log, whose definition is neither"), ([], "no column")):
            self.assert_refused(what, nlo.read_bag, rig, columns)
        self.assert_refused("no column \"/truth/x\"", nlo.read_bag, rig, None, None, {"/truth/x": 0})
        with Bag(self.folder / "json.db3") as other:
            other.topic("/a", "std_msgs/msg/Float64", "json")
        self.assert_refused("serialised as \"json\"", nlo.read_bag, self.folder / "json.db3")
        with Bag(self.folder / "short.db3") as other:
            other.message(other.topic("/a", "std_msgs/msg/Float64"), 1, float64(1.0)[:9])
            other.topic("/empty", "std_msgs/msg/Float64")
        self.assert_refused("short.db3: message 1 of /a ends after 9 bytes", nlo.read_bag, self.folder / "short.db3",
                            ["/a/data"])
        self.assert_refused("/empty has no messages", nlo.read_bag, self.folder / "short.db3", ["/a/data"], "/empty")
        for start, what in ((b"\x89MCAP0\r\n", "is an MCAP file: ros2 bag convert"), (b"#ROSBAG V2.0", "ROS 1"),
                            (b"\x28\xB5\x2F\xFD", "is compressed"), (b"", "log.db3: has 0 bytes"), (b"t,y\n" * 99, "log.db3: ")):
            self.assert_refused(what, nlo.read_bag, self.write("log.db3", start))

    def test_a_bag_that_ends_too_early_is_refused_and_wrong_bytes_raise_no_other_error(self):
        whole = self.rig().read_bytes()
        arguments = ["/imu/data/linear_acceleration.y", "/command/data"], "/imu/data/header.stamp"
        for part in range(60):
            cut = self.write("cut.db3", whole[:len(whole) * part // 60])
            self.assert_refused("cut.db3: ", nlo.read_bag, cut, *arguments)
        chance = random.Random(1)
        for _ in range(100):
            corrupted = bytearray(whole)
            for _ in range(20):
                corrupted[chance.randrange(len(whole))] = chance.randrange(256)
            self.refusal(nlo.read_bag, self.write("corrupted.db3", corrupted), *arguments)


@unittest.skipIf(scipy is None, "scipy is not installed (Debian: python3-scipy)")
class MatFiles(InAFolder):
    def rig(self, name="rig.mat", compressed=False):
        k = np.arange(SAMPLES, dtype=float)[:, None]
        signals = np.array([[(4 * k,), (5 * k,)]], dtype=[("values", object)])
        scipy.io.savemat(self.folder / name, {
            "t": 0.01 * k, "y": 0.5 * np.arange(2.0 * SAMPLES).reshape(2, -1).T,
            "across": np.arange(3.0 * SAMPLES).reshape(-1, 3).T, "single": (0.25 * k.T).astype(np.float32),
            "counts": (-7 * k).astype(np.int16), "gain": 0.0, "short": k[1:], "note": "hello", "cells": np.array([k, "x"], object),
            "turning": 1j * k, "cube": np.zeros((2, 3, 4)), "rig": {"angle": 2 * k, "inner": {"speed": 3 * k}},
            "signals": signals}, do_compression=compressed)
        return self.folder / name

    def test_variables_fields_and_columns_of_matrices_are_read(self):
        for compressed in (False, True):
            log = nlo.read_mat(self.rig(compressed=compressed), RIG)
            k = np.arange(SAMPLES)
            for name, values in zip(RIG, (0.01 * k, 0.5 * k, 0.5 * (k + SAMPLES), 3.0 * k + 2, 0.25 * k, -7.0 * k, 2.0 * k,
                                          3.0 * k, 5.0 * k)):
                np.testing.assert_array_equal(log[name], values, name)

    def test_without_names_all_vectors_of_the_most_frequent_length_are_read(self):
        log = nlo.read_mat(self.rig())
        self.assertLessEqual({"t", "y(1)", "y(2)", "across(1)", "counts", "rig.angle", "signals(1).values"}, set(log))
        self.assertNotIn("short", log)

    def test_errors_name_file_variable_and_remedy(self):
        rig = self.rig()
        for name, what in (("singel", "rig.mat: no variable \"singel\" among t, y, across, single"),
                           ("singel", "did you mean \"single\"?"),
                           ("rig.angel", "no field \"angel\" of rig among angle, inner; did you mean \"angle\"?"),
                           ("y", "y is 40 x 2: write y(1) for its first column"), ("y(3)", "y(3) is 40 x 2: it has no column (3)"),
                           ("short", "short is 39 x 1, and the log has 40 samples"),
                           ("gain", "gain is 1 x 1, and the log has 40 samples"),
                           ("note", "note is text: expected a vector of numbers"), ("cells", "cells is a cell array"),
                           ("turning", "turning is complex"), ("cube", "cube is of more than two dimensions"),
                           ("rig", "rig is not a number"), ("t.angle", "t is not a struct"),
                           ("signals.values", "signals is 2 structs: write signals(1).values to signals(2).values"),
                           ("signals(3).values", "signals is 2 structs"), ("y(0)", "does not name a variable")):
            self.assert_refused(what, nlo.read_mat, rig, ["t", name])
        self.assert_refused("log.mat: is damaged, or not a MAT-file", nlo.read_mat, self.write("log.mat", b"t,y\n0,1\n"))
        self.assert_refused("save it with save(..., \"-v7\")", nlo.read_mat,
                            self.write("new.mat", b"MATLAB 7.3 MAT-file, ".ljust(600)))
        with mock.patch.dict(sys.modules, {"scipy.io": None}):
            self.assert_refused("install the Debian package python3-scipy", nlo.read_mat, rig)

    def test_a_file_that_ends_too_early_is_refused(self):
        for compressed in (False, True):
            whole = self.rig(compressed=compressed).read_bytes()
            for length in range(0, len(whole), 1 + len(whole) // 150):
                self.assertRaises(nlo.Error, nlo.read_mat, self.write("cut.mat", whole[:length]), RIG)


class Conversion(InAFolder):
    def convert(self, *words):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            return convert.main([str(word) for word in words]), out.getvalue(), err.getvalue()

    def test_a_bag_becomes_a_csv_log_that_nlo_reads(self):
        bag_file = Bags.rig(self)
        status, out, _ = self.convert(bag_file, "-o", self.folder / "logs", "--interpolate", "/truth/twist.linear.x=0")
        self.assertEqual(status, 0)
        self.assertIn("rig.csv: 50 rows, 18 columns", out)
        heading, first = (self.folder / "logs/rig.csv").read_text().splitlines()[:2]
        self.assertTrue(heading.startswith("/imu/data/header.stamp,/imu/data/orientation.x,"), heading)
        self.assertTrue(first.startswith("0.0,0.0,"), first)
        subprocess.run([os.environ["NLO_PROGRAM"], "new", "log", self.folder / "logs/rig.csv", "-o", self.folder / "rig.toml",
                        "--states", "/truth/twist.linear.x", "--outputs", "/imu/data/linear_acceleration.x",
                        "--inputs", "/command/data"], check=True, capture_output=True)
        experiment = (self.folder / "rig.toml").read_text()
        self.assertIn("column = \"/imu/data/header.stamp\"", experiment)
        self.assertIn("column = \"/command/data\"", experiment)

    @unittest.skipIf(scipy is None, "scipy is not installed (Debian: python3-scipy)")
    def test_a_mat_file_becomes_a_csv_log_with_the_time_first(self):
        mat_file = MatFiles.rig(self)
        status, _, _ = self.convert(mat_file, "-o", self.folder, "--column", "rig.angle", "--column", "y(2)", "--time", "t")
        self.assertEqual(status, 0)
        lines = (self.folder / "rig.csv").read_text().splitlines()
        self.assertEqual(lines[:3], ["t,rig.angle,y(2)", "0.0,0.0,20.0", "0.01,2.0,20.5"])
        self.assertEqual(len(lines), SAMPLES + 1)

    def test_a_folder_means_all_files_of_its_bag(self):
        (self.folder / "bag").mkdir()
        for name in ("bag/bag_0.db3", "bag/bag_1.db3"):
            Bags.rig(self, name)
        self.assertEqual(self.convert(self.folder / "bag", "-o", self.folder / "logs")[0], 0)
        self.assertEqual(sorted(file.name for file in (self.folder / "logs").iterdir()), ["bag_0.csv", "bag_1.csv"])

    def test_errors_go_to_stderr_with_exit_status_1(self):
        for words, what in ((["no.db3"], "no.db3: No such file"),
                            (["a/log.db3", "b/log.db3"], "log.csv: two files would be written to it")):
            status, out, err = self.convert(*words, "-o", self.folder)
            self.assertEqual((status, out), (1, ""))
            self.assertIn("nlo.convert: error: ", err)
            self.assertIn(what, err)

    def test_the_program_names_the_converter_for_such_a_file(self):
        for name, start in (("rig.mat", b"MATLAB 5.0 MAT-file, Platform: GLNXA64"), ("rig.db3", b"SQLite format 3\0"),
                            ("rig.mcap", b"\x89MCAP0\r\n")):
            ran = subprocess.run([os.environ["NLO_PROGRAM"], "new", "log", self.write(name, start + b"\n\0,1\n" * 30)],
                                 capture_output=True, text=True)
            self.assertEqual(ran.returncode, 2, ran.stderr)
            self.assertIn("python3 -m nlo.convert", ran.stderr)


if __name__ == "__main__":
    unittest.main()
