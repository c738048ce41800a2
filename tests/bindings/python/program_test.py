# SPDX-License-Identifier: MIT
"""Training, evaluation, export and maps from other libraries, in the package nlo."""
import json
import os
import pathlib
import signal
import tempfile
import threading
import time
import unittest

import numpy as np

import nlo

SOURCE = pathlib.Path(os.environ["NLO_SOURCE_DIR"])
VAN_DER_POL = SOURCE / "examples/models/van_der_pol.json"
PENDULUM = {
    "name": "pendulum",
    "plant": {"states": ["angle", "rate"], "derivative": ["rate", "-g / l * sin(angle) - 0.1 * rate"],
              "output_names": ["angle_measured"], "outputs": ["angle"], "parameters": {"g": 9.81, "l": 0.5}},
    "simulation": {"initial_low": [-1.5, -3.0], "initial_high": [1.5, 3.0], "trajectories": 20, "horizon_s": 5.0},
    "observer": {"eigenvalues": [-4.0, -8.0, -12.0]},
    "inverse_map": {"hidden": [8]},
    "training": {"noise": "gaussian:0.05", "steps": 300, "validate_every": 100},
}
LOG = {
    "name": "swing",
    "log": {"columns": [{"name": "time", "role": "time", "unit": "s"},
                        {"name": "angle", "role": "output", "unit": "rad"}, {"name": "rate", "role": "state", "unit": "rad/s"}]},
    "observer": {"eigenvalues": [-4.0, -8.0, -12.0], "learn_eigenvalues": False},
    "inverse_map": {"hidden": [8]},
    "training": {"steps": 200, "validate_every": 100},
}


def swing(seed):
    """Returns a damped swing as a table; each seed has its own initial state."""
    t = 0.02 * np.arange(600)
    phase, size = np.random.default_rng(seed).uniform([0, 0.5], [6, 1.5])
    angle = size * np.exp(-0.1 * t) * np.cos(4 * t + phase)
    return {"time": t, "angle": angle, "rate": np.gradient(angle, t)}


class Frame:
    """The part of a pandas DataFrame that the package uses."""

    def __init__(self, columns):
        self._columns, self.columns = columns, list(columns)

    def __getitem__(self, name):
        return self._columns[name]

    def __contains__(self, name):
        return name in self._columns


class InAFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)


class Trainings(InAFolder):
    def test_a_plant_from_a_dict_is_trained_shown_and_evaluated(self):
        rows = []
        training = nlo.train(PENDULUM, output=self.folder / "run", progress=rows.append, seed=3)
        self.assertEqual([s.name for s in training.model.states], ["angle", "rate"])
        self.assertEqual([row["step"] for row in rows], list(training.metrics["step"]))
        self.assertEqual(training.metrics["step"][-1], 300)
        self.assertTrue(training.report.exists())
        self.assertIn("observer", training.text)
        self.assertRegex(repr(training), r"^<nlo.Training in .*run: 300 steps, validation_rmse [0-9.e-]+>$")
        for model in (training.model, training.directory / "model.json"):
            found = nlo.evaluate(model, noise=["none", "gaussian:0.05"], trajectories=10, against=["ekf"])
            self.assertEqual([each.noise for each in found], ["none", "gaussian:0.05"])
            self.assertEqual(set(found[0].rmse), {"angle", "rate"})
            self.assertRegex(repr(found[0]), r"^<nlo.Evaluation under noise none: norm [0-9.e-]+; RMSE angle [0-9.e-]+, "
                                             r"rate [0-9.e-]+>$")
            self.assertLessEqual({"ekf", "constant", "ridge"}, set(found[0].against))
            self.assertLess(found[0].rmse["rate"], found[0].against["constant"]["rate"])
        # the same bytes as from the command
        again = nlo.train(self.folder / "run/experiment.toml", output=self.folder / "again", seed=3)
        self.assertEqual(again.model.json, training.model.json)

    def test_frames_are_the_logs_of_a_training(self):
        by_name = {"a": swing(1), "b": Frame(swing(2)), "test": Frame(swing(3))}
        for index, data in enumerate((by_name, [swing(1), swing(2)])):
            output = self.folder / str(index)
            training = nlo.train(LOG, data=data, output=output)
            self.assertEqual([s.unit for s in training.model.states], ["rad/s"])
            for name in ("a.csv", "b.csv", "test.csv") if index == 0 else ("log_1.csv", "log_2.csv"):
                self.assertTrue((output / "data" / name).exists(), name)
        back = np.genfromtxt(self.folder / "0/data/a.csv", delimiter=",", names=True)
        np.testing.assert_array_equal(back["angle"], swing(1)["angle"])  # all digits
        found = nlo.evaluate(training.model, data=[swing(4)])
        self.assertLess(found[0].rmse["rate"], found[0].against["constant"]["rate"])

    def test_a_refused_experiment_is_an_error_with_the_text_of_the_command(self):
        with self.assertRaisesRegex(nlo.Error, r'experiment.toml:\d+: unknown key "stpes".*did you mean "steps"'):
            nlo.train({**PENDULUM, "training": {"stpes": 3}}, output=self.folder / "run")
        with self.assertRaisesRegex(nlo.Error, "columns of log.csv differ in length"):
            nlo.train(LOG, data={"time": np.zeros(3), "angle": np.zeros(2)}, output=self.folder / "run")
        with self.assertRaisesRegex(nlo.Error, "did you mean"):
            nlo.evaluate(VAN_DER_POL, trajectoires=3)

    def test_an_interrupt_ends_the_training_with_its_best_model(self):
        interrupted = threading.Timer(0, lambda: None)

        def interrupt_once(row):
            nonlocal interrupted
            if not interrupted.is_alive() and row["step"] >= 200:
                interrupted = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))
                interrupted.start()

        long = {**PENDULUM, "training": {**PENDULUM["training"], "steps": 200_000}}
        with self.assertRaisesRegex(KeyboardInterrupt, "has the best model so far"):
            nlo.train(long, output=self.folder / "run", progress=interrupt_once)
        self.assertEqual(nlo.Model.load(self.folder / "run/model.json").name, "pendulum")

    def test_an_exception_of_progress_ends_the_training(self):
        def stop(row):
            raise ValueError("enough")

        began = time.monotonic()
        with self.assertRaisesRegex(ValueError, "enough"):
            nlo.train({**PENDULUM, "training": {"steps": 200_000}}, output=self.folder / "run", progress=stop)
        self.assertLess(time.monotonic() - began, 120)


class Exports(InAFolder):
    def test_exports_are_compiled_and_compared_with_the_model(self):
        model = nlo.Model.load(VAN_DER_POL)
        written = nlo.export(model, "c99", self.folder / "van_der_pol.h")
        self.assertIn("x1", written.text)
        found = nlo.validate(model, written.path)
        self.assertTrue(found.passed, found.max_error)
        self.assertEqual(found.exported.shape, (400, 2))
        fields = model.fields
        fields["inverse_map"]["layers"][-1]["bias"][0] += 0.01
        other = nlo.Model(json.dumps(fields).encode())
        self.assertFalse(nlo.validate(other, written.path).passed, "control: another model does not pass")
        (self.folder / "van_der_pol.c").write_text("int x = ;")
        with self.assertRaisesRegex(nlo.Error, "does not compile"):
            nlo.validate(model, written.path)
        with self.assertRaisesRegex(nlo.Error, "none.h: no such file"):
            nlo.validate(model, self.folder / "none.h")

    def test_a_warning_of_the_command_becomes_a_python_warning(self):
        path = pathlib.Path(os.environ["NLO_TEST_MODELS"]) / "tiny_relu_error.json"
        with self.assertWarnsRegex(UserWarning, "^the standard deviations of its errors are left out"):
            nlo.export(path, "c99", self.folder / "tiny_relu_error.h")

    def test_a_model_with_inputs_is_compiled_with_them(self):
        path = pathlib.Path(os.environ["NLO_TEST_MODELS"]) / "commanded.json"
        nlo.export(path, "c99", self.folder / "commanded.h", scalar="double")
        self.assertTrue(nlo.validate(path, self.folder / "commanded.h", scalar="double").passed)


class Tensor:
    """The part of a torch.Tensor on a device, with gradients, that the package uses."""

    def __init__(self, values):
        self._values = values

    def detach(self):
        return _Detached(self._values)


class _Detached(Tensor):
    def cpu(self):
        return self._values


class Maps(InAFolder):
    def setUp(self):
        super().setUp()
        self.model = nlo.Model.load(VAN_DER_POL)
        random = np.random.default_rng(1)
        self.layers = [(random.normal(size=(8, 6)), random.normal(size=8)),
                       (random.normal(size=(2, 8)), np.array([0.1, -0.1]))]

    def test_layers_from_other_libraries_become_the_map_and_can_be_exported(self):
        state_dict = {"net.0.weight": Tensor(self.layers[0][0]), "net.0.bias": Tensor(self.layers[0][1]),
                      "net.2.weight": Tensor(self.layers[1][0]), "net.2.bias": Tensor(self.layers[1][1])}
        z = self.model.run(np.sin(0.05 * np.arange(100))).z
        for layers in (self.layers, state_dict):
            for activation, function in (("tanh", np.tanh), ("relu", lambda a: np.maximum(a, 0)),
                                         ("silu", lambda a: a / (1 + np.exp(-a)))):
                model = self.model.with_map(layers, activation=activation)
                want = function(z @ self.layers[0][0].T + self.layers[0][1]) @ self.layers[1][0].T + self.layers[1][1]
                np.testing.assert_allclose(model.inverse_map(z, np.zeros((100, 1))), want, atol=1e-12)
        self.assertEqual(self.model.json, nlo.Model.load(VAN_DER_POL).json, "the model itself does not change")
        nlo.export(model, "c99", self.folder / "van_der_pol.h")
        self.assertTrue(nlo.validate(model, self.folder / "van_der_pol.h").passed)

    def test_scales_apply_to_inputs_and_outputs(self):
        z = np.linspace(-0.5, 0.5, 60).reshape(10, 6)
        model = self.model.with_map(self.layers, input_mean=np.full(6, 0.1), input_scale=np.full(6, 2.0),
                                    output_mean=[1.0, 2.0], output_scale=[3.0, 4.0])
        (w0, b0), (w1, b1) = self.layers
        inner = np.tanh((z - 0.1) / 2.0 @ w0.T + b0) @ w1.T + b1
        np.testing.assert_allclose(model.inverse_map(z, np.zeros((10, 1))), [1.0, 2.0] + inner * [3.0, 4.0], atol=1e-12)
        old = self.model.fields["inverse_map"]
        same = self.model.with_map([(layer["weights"], layer["bias"]) for layer in old["layers"]], normalised=True)
        if not old["skip"]:
            y = np.zeros((10, 1))
            np.testing.assert_array_equal(same.inverse_map(z, y), self.model.inverse_map(z, y))

    def test_layers_that_do_not_fit_are_refused(self):
        (w0, b0), (w1, b1) = self.layers
        for layers, words in (([(w0[:, :4], b0), (w1, b1)], r"T\* of this model may read 6 \(z\) or 7"),
                              ([(w0, b0), (w1[:, :3], b1)], r"layers\[1\] reads 3 numbers, the one before it gives 8"),
                              ([(w0, b0), (w1[:1], b1[:1])], "the model estimates 2 states"),
                              ([(w0, b0[:3]), (w1, b1)], r"layers\[0\]: weights \(8, 6\) and bias \(3,\)"),
                              ([], "there are no layers"), ({"a.weight": w0}, "a.bias is missing"),
                              ({"lstm.weight_ih_l0": w0}, "T\\* is an MLP"),
                              ([(np.full_like(w0, np.nan), b0), (w1, b1)], "weights")):
            with self.assertRaisesRegex(nlo.Error, words):
                self.model.with_map(layers)
        with self.assertRaisesRegex(nlo.Error, "activation"):
            self.model.with_map(self.layers, activation="gelu")


if __name__ == "__main__":
    unittest.main()
