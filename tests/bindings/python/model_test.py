# SPDX-License-Identifier: MIT
"""Models, observers and runs of the package nlo.   usage: model_test.py [unittest's], with NLO_TEST_MODELS: a folder"""
import concurrent.futures
import copy as copies
import json
import os
import pathlib
import pickle
import tempfile
import time
import unittest

import numpy as np

import nlo

MODELS = pathlib.Path(os.environ["NLO_TEST_MODELS"])  # models that export_model writes, which cover all features
VAN_DER_POL = pathlib.Path(os.environ["NLO_SOURCE_DIR"]) / "examples/models/van_der_pol.json"


def models():
    return [nlo.Model.load(path) for path in sorted(MODELS.glob("*.json"))]


def measured(model, samples=60):
    """Returns outputs and inputs within their ranges; one reading of each output is missing."""
    def waves(channels):
        k = np.arange(samples)[:, np.newaxis]
        low = np.array([max(channel.low, -1.0) for channel in channels])
        high = np.array([min(channel.high, 1.0) for channel in channels])
        return (low + high) / 2 + 0.4 * (high - low) * np.sin(0.1 * k + np.arange(len(channels)))

    y = waves(model.outputs)
    y[20 % samples] = np.nan
    return y, waves(model.inputs) if model.inputs else None


class Models(unittest.TestCase):
    def test_a_run_equals_its_steps_for_every_structure(self):
        structures = set()
        for model in models():
            with self.subTest(model=model.name):
                y, u = measured(model)
                run = model.run(y, u, precision="double")
                observer = model.observer("double")
                for k in range(len(y)):
                    status = observer.step(y[k], None if u is None else u[k])
                    self.assertEqual(status, run.status[k])
                    np.testing.assert_array_equal(observer.latent, run.z[k])
                    # products with matrices and with vectors sum in a different order
                    rounding = 1e-10 * (1 + np.abs(run.x_hat).max())
                    np.testing.assert_allclose(observer.estimate(), run.x_hat[k], rtol=0, atol=rounding)
                    self.assertEqual(observer.in_domain, run.in_domain[k])
                    if model.has_sigma:
                        np.testing.assert_allclose(observer.estimate_with_error()[1], run.sigma[k], rtol=1e-9)
                self.assertIn(nlo.Status.HELD, run.status)
                self.assertEqual(run.sigma is not None, model.has_sigma)
                structures.add(model.structure)
        self.assertEqual(structures, {"kkl", "driven_kkl", "luenberger", "general", "gated", "carried", "prior"})

    def test_names_units_and_the_sample_period_are_those_of_the_file(self):
        for model in models():
            fields = model.fields
            self.assertEqual([s.name for s in model.states], [s["name"] for s in fields["states"]])
            self.assertEqual([s.unit for s in model.states], [s["unit"] for s in fields["states"]])
            self.assertEqual(model.sample_period_s, fields["sample_period_s"])

    def test_the_latent_system_and_the_map_reproduce_the_run(self):
        model = nlo.Model.load(VAN_DER_POL)
        y = np.sin(0.05 * np.arange(400))
        run = model.run(y, precision="double")
        # dz/dt = D z + F y, with y a ramp between samples, by small steps of RK4: (4/s * 20 ms / 20)^4 / 120 is 1e-12
        z, h = run.z[0], model.sample_period_s / 20
        for k in range(399):
            for i in range(20):
                def slope(at, c, k=k, i=i):
                    s = (i + c) / 20
                    return model.D @ at + model.F[:, 0] * ((1 - s) * y[k] + s * y[k + 1])
                a = slope(z, 0)
                b = slope(z + h / 2 * a, 0.5)
                c = slope(z + h / 2 * b, 0.5)
                z = z + h / 6 * (a + 2 * b + 2 * c + slope(z + h * c, 1))
            if k == 20:
                break
        np.testing.assert_allclose(z, run.z[21], atol=1e-10)
        np.testing.assert_allclose(model.inverse_map(run.z, y[:, np.newaxis]), run.x_hat, atol=1e-12)
        self.assertTrue((model.eigenvalues.real < 0).all())
        with self.assertRaisesRegex(nlo.Error, "does not run as D z"):
            nlo.Model.load(MODELS / "gated.json").D

    def test_frames_and_mappings_give_the_results_of_arrays(self):
        model = nlo.Model.load(MODELS / "commanded.json")
        y, u = measured(model)
        table = {channel.name: column for channels, data in ((model.outputs, y), (model.inputs, u))
                 for channel, column in zip(channels, data.T)}
        np.testing.assert_array_equal(model.run(table).x_hat, model.run(y, u).x_hat)
        with self.assertRaisesRegex(nlo.Error, f"there is no column {model.outputs[0].name}"):
            model.run({"wrong": y})

    def test_errors_of_wrong_shapes_name_the_right_shape(self):
        model = nlo.Model.load(MODELS / "commanded.json")
        y, u = measured(model)
        for arguments, words in (((y[:, :0], u), "y has the shape"), ((y,), "u is missing"), ((y, u[1:]), "u has"),
                                 ((y, u, np.zeros(3)), "t has 3 samples"),
                                 ((y, u, np.zeros((len(y), 2))), "t has the shape")):
            with self.assertRaisesRegex(nlo.Error, words):
                model.run(*arguments)
        with self.assertRaisesRegex(nlo.Error, 'precision "half"'):
            model.observer("half")
        with self.assertRaisesRegex(nlo.Error, "y has 9 numbers"):
            model.observer().step(np.zeros(9), u[0])

    def test_copies_of_an_observer_are_independent(self):
        model = nlo.Model.load(VAN_DER_POL)
        first = model.observer()
        first.step(1.0)
        before = first.save()
        for other in (copies.copy(first), copies.deepcopy(first), pickle.loads(pickle.dumps(first)), first.copy()):
            np.testing.assert_array_equal(other.save(), before)
            self.assertEqual(other.precision, first.precision)
            other.step(2.0)
            self.assertFalse(np.array_equal(other.save(), before))
            np.testing.assert_array_equal(first.save(), before)
            del other  # each observer frees its own state
        self.assertIs(copies.deepcopy(model), model)

    def test_masked_values_none_and_na_are_missing_samples(self):
        class NAType:  # like that of pandas
            pass

        class Series:  # like that of pandas, whose NA numpy cannot read
            def to_numpy(self, dtype, na_value):
                return np.array([0.1, na_value, 0.2], dtype=dtype)

        model = nlo.Model.load(VAN_DER_POL)
        want = model.run([0.1, np.nan, 0.2])
        self.assertEqual(list(want.status), [nlo.Status.OK, nlo.Status.HELD, nlo.Status.OK])
        for y in (np.ma.masked_array([0.1, 1e6, 0.2], mask=[False, True, False]), [0.1, None, 0.2], [0.1, NAType(), 0.2],
                  {"y": Series()} if model.outputs[0].name == "y" else Series()):
            np.testing.assert_array_equal(model.run(y).x_hat, want.x_hat)
            np.testing.assert_array_equal(model.run(y).status, want.status)
        self.assertEqual(model.observer().step(np.ma.masked), nlo.Status.HELD)

    def test_wrong_types_raise_a_type_error_with_the_arguments_name(self):
        model = nlo.Model.load(VAN_DER_POL)
        observer = model.observer()
        for call, name in ((lambda: observer.step("fast"), "y"), (lambda: observer.step(object()), "y"),
                           (lambda: observer.step(0.0, dt="now"), "dt"), (lambda: model.run(["a", "b"]), "y"),
                           (lambda: model.run([0.1], t=["x"]), "t"), (lambda: observer.restore("old"), "state"),
                           (lambda: nlo.Model("model.json"), "data")):
            with self.assertRaisesRegex(TypeError, f"^{name} must be"):
                call()
        with self.assertRaisesRegex(nlo.Error, "precision"):
            model.observer(32)

    def test_results_print_as_a_summary(self):
        model = nlo.Model.load(VAN_DER_POL)
        observer = model.observer()
        observer.step(0.5)
        self.assertRegex(repr(observer), r"^<nlo.Observer of van_der_pol: OK, x1 -?[0-9.e-]+, x2 ")
        self.assertRegex(repr(model.run(np.zeros(50))),
                         r"^<nlo.Run of 50 samples over [0-9.]+ s: x1, x2; [0-9.]+% in the domain, worst status OK>$")

    def test_errors_have_the_text_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "cut.json"
            path.write_bytes(VAN_DER_POL.read_bytes()[:400])
            with self.assertRaisesRegex(nlo.Error, f"^{path}:.*it was cut off, copy it again"):
                nlo.Model.load(path)
            with self.assertRaisesRegex(nlo.Error, "none.json: No such file"):
                nlo.Model.load(pathlib.Path(folder) / "none.json")
        fields = nlo.Model.load(VAN_DER_POL).fields
        fields["eigenvalues"][0] = 1.0
        with self.assertRaisesRegex(nlo.Error, "eigenvalues"):
            nlo.Model(json.dumps(fields).encode())

    def test_observers_can_be_saved_copied_and_reset_and_models_pickled(self):
        for model in models():
            y, u = measured(model)
            observer = model.observer()

            def step(which, k, y=y, u=u):
                which.step(y[k], None if u is None else u[k])

            for k in range(30):
                step(observer, k)
            copy, restored = observer.copy(), pickle.loads(pickle.dumps(model)).observer()
            restored.restore(observer.save())
            for k in range(30, 60):
                for each in (observer, copy, restored):
                    step(each, k)
            np.testing.assert_array_equal(copy.save(), observer.save())
            np.testing.assert_array_equal(restored.save(), observer.save())
            observer.reset()
            np.testing.assert_array_equal(observer.save(), model.observer().save())
            with self.assertRaisesRegex(nlo.Error, "it belongs to another model"):
                observer.restore(np.zeros(2))

    def test_irregular_steps_follow_the_time_stamps(self):
        model = nlo.Model.load(VAN_DER_POL)
        t = np.cumsum(model.sample_period_s * (1 + 0.5 * np.sin(np.arange(50))))
        y = np.cos(t)
        run = model.run(y, t=t, precision="double")
        observer = model.observer("double")
        for k in range(50):
            observer.step(y[k], dt=None if k == 0 else t[k] - t[k - 1])
        np.testing.assert_array_equal(observer.latent, run.z[-1])
        self.assertGreater(np.abs(run.z[-1] - model.run(y).z[-1]).max(), 1e-4, "control: steps matter")
        self.assertEqual(observer.step(0.0, dt=-1.0), nlo.Status.REJECTED)

    def test_other_threads_run_while_an_observer_runs(self):
        model = nlo.Model.load(VAN_DER_POL)
        y = np.zeros(400_000)
        with concurrent.futures.ThreadPoolExecutor(1) as pool:
            running, turns = pool.submit(model.run, y), 0
            while not running.done():
                turns += 1
                time.sleep(0.001)
        self.assertGreater(turns, 5, "other threads waited for the run")
        self.assertEqual(len(running.result()), len(y))


if __name__ == "__main__":
    unittest.main()
