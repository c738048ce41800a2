#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""
usage: examples/rigs/unseen.py NLO LOGS [SEED]

Which cheap score detects estimates that are not to be trusted? Trains observers of three rigs with whole groups of logs
left out (program NLO, logs below LOGS). For each score and each set of logs that training has not seen, it prints the
share of missed samples (the error is over three times the validation error, but the score raises no flag) and the share
of flagged samples. Thresholds are set to 1 % false flags on the validation logs. Needs numpy.

  box       z is in the model's domain, as in_domain() tests it
  whole     Mahalanobis distance of v = [z; y; u]
  least 4   the four directions of v with the least variance
  rows      of v and the estimate, two directions w with the largest var(w . v over faults) / var(w . v over training)
  hidden    the same for the last hidden layer of T*
  ~ held    averaged over six time constants of the slowest mode

Faults are made from training logs: from a random sample on, a reading is zero, stuck, shifted, scaled or that of another
log. Only faults whose error is over three times the validation error count.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

FAULTS_OF_A_LOG = 8
REGULARISATION = 1e-4  # relative to features of variance 1
MOST = 50.0  # limit of a squared row, so that the average soon forgets one outlier
TEMPERATURES = ("25degC", "10degC", "0degC", "n10degC")


class Observer:
    """Computes z and T* of a model file in double."""

    def __init__(self, file):
        m = json.loads(pathlib.Path(file).read_text())
        number = {key: np.array(m[key]) for key in ("eigenvalues", "output_injection", "initial_latent", "latent_min",
                                                    "latent_max", "output_min", "output_max")}
        pairs, net = m["pairs"], m["inverse_map"]
        self.ny, self.nu, self.nx = len(m["outputs"]), len(m.get("inputs", [])), len(m["states"])
        self.period, self.command = m["sample_period_s"], m.get("input_hold") == "zero_order"
        split = lambda a: np.concatenate([a[0:2 * pairs:2] + 1j * a[1:2 * pairs:2], a[2 * pairs:]])
        self.modes, self.f = split(number["eigenvalues"]), split(number["output_injection"])
        self.pairs, self.first, self.steady = pairs, split(number["initial_latent"]), m["starts_steady"]
        self.gain = self.joined(-(self.f / self.modes[:, None]).T).T
        self.relative = sorted({*m.get("relative_outputs", []), *(j for j, o in enumerate(m["outputs"]) if o["wrap"])})
        self.absolute = [j for j in range(self.ny + self.nu) if j not in self.relative]
        self.low, self.high = (np.concatenate([number[f"output_{end}"], m.get(f"input_{end}", [])])
                               for end in ("min", "max"))
        self.box = number["latent_min"], number["latent_max"]
        self.reach = 0.5 * m["saturation"] * (self.box[1] - self.box[0]) if m.get("saturation") else np.inf
        self.net = {key: np.array(net[key]) for key in ("features", "feature_mean", "feature_scale", "output_mean",
                                                        "output_scale")}
        self.layers = [(np.array(a["weights"]), np.array(a["bias"])) for a in net["layers"]]
        self.skip = np.array(net["skip"]) if net.get("skip") else np.zeros((self.nx, len(net["feature_mean"])))
        self.act = np.tanh if net["activation"] == "tanh" else lambda a: a / (1 + np.exp(-a))
        self.slowest = 1 / np.abs(self.modes.real[np.abs(self.f).sum(1) > 0]).min()
        self.products = (sum(w.size for w, _ in self.layers) + self.skip.size + len(self.box[0]) + 2 * pairs +
                         2 * np.count_nonzero(number["output_injection"]))

    def joined(self, modes):  # from (..., modes) to (..., n_z)
        pairs = np.stack([modes[..., :self.pairs].real, modes[..., :self.pairs].imag], -1)
        return np.concatenate([pairs.reshape(*modes.shape[:-1], -1), modes[..., self.pairs:].real], -1)

    def run(self, step, readings, truth):
        """Returns the values of the observer at each sample. `step` 0: one period."""
        r = np.clip(readings, self.low, self.high)
        z = self.first + (-(self.f / self.modes[:, None]) @ r[0] if self.steady else 0)
        states = [z]
        for k in range(1, len(r)):
            x = self.modes * (step[k] or self.period)
            last = r[k - 1].copy()
            if self.command:
                last[self.ny:] = r[k, self.ny:]
            from_, to = self.f @ last, self.f @ r[k]
            once = np.expm1(x) / x
            z = np.exp(x) * z + x / self.modes * (once * from_ + (once - 1) / x * (to - from_))
            states.append(z)
        z = self.joined(np.array(states))
        rest = r[:, self.relative] @ self.gain[:, self.relative].T
        place = z - rest
        within = rest + np.clip(place, self.box[0] - self.reach, self.box[1] + self.reach)
        n = self.net
        read = np.hstack([within, r])[:, :n["features"].shape[1]]
        u = (read @ n["features"].T - n["feature_mean"]) / n["feature_scale"]
        hidden = u
        for w, b in self.layers[:-1]:
            hidden = self.act(hidden @ w.T + b)
        w, b = self.layers[-1]
        x_hat = n["output_mean"] + n["output_scale"] * (hidden @ w.T + b + u @ self.skip.T)
        outside = ((place < self.box[0]) | (place > self.box[1])).any(1)
        v = np.hstack([place, r[:, self.absolute]])
        return dict(step=step, r=r, truth=truth, error=x_hat - truth, outside=outside * 1.0, v=v, hidden=hidden,
                    seen=np.hstack([v, x_hat]), x_hat=x_hat)


def logs(nlo, observer, model, files, scratch):
    """Reads runs over log files that `nlo evaluate --estimates` writes, and checks our estimates against its own."""
    runs = []
    for file in files:
        out = pathlib.Path(tempfile.mkdtemp(dir=scratch), "run.csv")
        subprocess.run([nlo, "evaluate", model, "--data", file, "--estimates", out], check=True, capture_output=True)
        for part in sorted(out.parent.glob("run*.csv")):  # one for each piece of a log with gaps
            table = np.genfromtxt(part, delimiter=",", skip_header=1)
            at = 2 + observer.ny + observer.nu
            run = observer.run(table[:, 1], table[:, 2:at], table[:, at + observer.nx + 1:])
            theirs = table[:, at:at + observer.nx]
            if np.abs(run["x_hat"] - theirs).max() > 1e-3 * np.abs(theirs).max():  # float32, and a margin
                sys.exit(f"{file}: other estimates than those of nlo")
            runs.append(run)
    return runs


def with_fault(observer, run, column, change, at):
    readings = run["r"].copy()
    readings[at:, column] = change(readings[at:, column])
    changed = observer.run(run["step"], readings, run["truth"])
    return {key: values[at:] for key, values in changed.items()}


def faults(observer, training, random):
    deviation = all_of(training, "r").std(0)
    for run in training * FAULTS_OF_A_LOG:
        j, at = random.integers(observer.ny + observer.nu), random.integers(len(run["r"]) // 2 + 1)
        other = training[random.integers(len(training))]["r"][:, j]
        shift = deviation[j] * random.choice((-1, 1)) * np.exp(random.uniform(-1.2, 0.7))
        scale = random.choice((.5, .7, 1.4, 2))
        change = (lambda y: 0 * y, lambda y: 0 * y + y[0], lambda y: y + shift, lambda y: y * scale,
                  lambda y: np.resize(np.roll(other, random.integers(len(other))), len(y)))[random.integers(5)]
        yield with_fault(observer, run, j, change, at)


def all_of(runs, key):
    return np.concatenate([run[key] for run in runs])


def distance(key, training, count, over=None):
    """Returns the sum of squares of `count` directions with the largest var(over) / var(training), or with the least
    variance without `over`."""
    x = all_of(training, key)
    mean, deviation = x.mean(0), x.std(0) + 1e-9
    normal = lambda a: (a - mean) / deviation
    variance, axes = np.linalg.eigh(np.cov(normal(x).T))
    white = axes / np.sqrt(np.maximum(variance, 0) + REGULARISATION)
    far = np.eye(len(mean)) if over is None else np.clip(normal(over), -20, 20).T @ np.clip(normal(over), -20, 20)
    rows = white @ np.linalg.eigh(white.T @ far @ white)[1][:, ::-1][:, :count]
    return lambda run: np.minimum((normal(run[key]) @ rows) ** 2, MOST).sum(1), count * (len(mean) + 1)


def held(score, observer):
    def averaged(run):
        gain, value, values = 1 - np.exp(-observer.period / (6 * observer.slowest)), None, []
        for s in score(run):
            value = s if value is None else value + gain * (s - value)
            values.append(value)
        return np.array(values)
    return averaged


def splits(logs_folder):
    """Yields name, experiment, training and validation files, unseen: name -> files, dead: name -> (files, column, change)."""
    files = lambda rig, pattern: [f for f in sorted(logs_folder.glob(f"{rig}/*.csv")) if re.search(pattern, f.name)]
    car, circles = lambda p: files("car", p), r"rubber_(0|1[0-5])"
    dead = {"encoder 0": (car(r"rubber_17|free_02"), 3, lambda y: 0 * y)}
    new = {"fast": car("fast"), "free": car("free_02")}
    yield "car", "car", car(circles + "|free_01|steer"), car("rubber_16"), new, dead
    yield "no free", "car", car(circles + "|steer"), car("rubber_16"), {"free": car("free"), "fast": car("fast")}, {}
    yield "no steps", "car", car(circles + "|free_01"), car("rubber_16"), {"steps": car("steer")}, {}
    rubber = {"rubber": car("rubber"), "free": car("free_02")}
    yield "no rubber", "car", car("free_01|steer|fast_01"), car("fast_02"), rubber, {}
    for left in TEMPERATURES:
        of = lambda which, left=left: [f for f in files("battery", rf"_Mixed[{which}]") if not f.name.startswith(left)]
        shifted = {"+50 mV": (of("7")[:1], 0, lambda y: y + .05)} if left == "25degC" else {}
        yield f"no {left}", "battery", of("1245"), of("6"), {left: files("battery", rf"^{left}_Mixed[67]")}, shifted
    for left in range(4):
        of = lambda *steps, left=left: [f for s in steps for f in files("double_pendulum", f"0{(left + s) % 4}")]
        yield f"no log {left}", "double_pendulum", of(2, 3), of(1), {f"log {left}": of(0)}, {}


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__.strip())
    nlo, folder, seed = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3] if len(sys.argv) == 4 else "1"
    print(f"{'left out':14}{'unseen':12}{'score':10}{'cost %':>7}{'silent':>8}{'flagged':>8}")
    for name, experiment, training, validation, unseen, dead in splits(folder):
        with tempfile.TemporaryDirectory() as scratch:
            kinds = {"train": training, "validation": validation, "test": next(iter(unseen.values()))}
            named = [f"--set=log.{kind}_files={json.dumps([f.name for f in paths])}" for kind, paths in kinds.items()]
            subprocess.run([nlo, "train", experiment, "--data", training[0].parent, "-o", scratch, "--seed", seed, "-q",
                            "--force", *named], check=True, capture_output=True)
            model = pathlib.Path(scratch, "model.json")
            observer = Observer(model)
            read = lambda paths: logs(nlo, observer, model, paths, scratch)
            seen, judged = read(training), read(validation)
            sets = {key: read(paths) for key, paths in unseen.items()}
            for key, (paths, column, change) in dead.items():
                sets[key] = [with_fault(observer, run, column, change, 0) for run in read(paths)]
        limit = 3 * np.sqrt(np.nanmean(all_of(judged, "error") ** 2, 0))
        wrong = lambda runs: (np.abs(all_of(runs, "error")) > limit).any(1)
        made = list(faults(observer, seen, np.random.default_rng(1)))
        over = {key: all_of(made, key)[wrong(made)] for key in ("seen", "hidden")}
        scores = {"box": (lambda run: run["outside"], 2 * len(observer.box[0])),
                  "whole": distance("v", seen, seen[0]["v"].shape[1]), "least 4": distance("v", seen, 4),
                  "rows": distance("seen", seen, 2, over["seen"]),
                  "hidden": distance("hidden", seen, 2, over["hidden"])}
        scores |= {f"~{key}": (held(scores[key][0], observer), scores[key][1]) for key in ("least 4", "rows", "hidden")}
        for key, runs in sets.items():
            for score, (value, cost) in scores.items():
                of = lambda some: np.concatenate([value(run) for run in some])
                flagged = of(runs) > (0.5 if score == "box" else np.quantile(of(judged), 0.99))
                print(f"{name:14}{key:12}{score:10}{100 * cost / observer.products:7.1f}"
                      f"{100 * (wrong(runs) & ~flagged).mean():8.1f}{100 * flagged.mean():8.1f}", flush=True)


if __name__ == "__main__":
    main()
