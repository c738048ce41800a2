#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Flies fully trained observers behind their monitors, as a user would: exported to C++ and to C99, in closed loops and
on logs, from rest, restarted, over gaps, at another rate, with sensors that fail.

usage: tests/flown/fly.py NLO SOURCE_DIR WORK_DIR [MODEL...]

  NLO       the program
  WORK_DIR  trained models, kept until the program or an experiment changes, and exports
  MODEL     of these alone: motor van_der_pol balance qube double_pendulum (default: all; logs that are not there are
            left out)

A table row per flight:
  error    rms over that in nominal flight, of the state that is worst
  lost     seconds that end a second whose rms error is over five times the nominal rms
  told     share of those with a status, in_domain() or alarm that says so within that second, or a monitor that is
           not armed
  false    share of all other seconds in which one of them does
  gate     rms error behind the gate over that without it

Exit 1 where a flight breaks a promise of docs/monitor.md: the gate costs more than 5 % in nominal flight, after a
restart, a jump or a gap; nominal flight is told to be lost for more than 1 % of its time; a lost flight is told in less
than 95 % of its lost seconds and is not one of KNOWN_SILENT.
"""
import csv
import ctypes
import hashlib
import json
import math
import pathlib
import subprocess
import sys

import numpy as np

FAR, LASTING_S = 5.0, 1.0  # times the nominal rms; how long, until a flight is lost
MOST_GATE_COST, MOST_FALSE, LEAST_TOLD = 1.05, 0.01, 0.95
LOST_BITS = 1 | 2 | 4  # status, domain, alarm: flown.cpp
ARMED_BIT = 16

# (model, flight): why no status, domain or alarm tells that the estimate is lost. docs/monitor.md lists them.
KNOWN_SILENT = {
    ("balance", "biased 0"): "the pendulum balances where the biased sensor reads 0: it looks like a constant torque",
}


class Exported:
    """An observer with its monitor, compiled from what nlo has exported."""

    def __init__(self, library, period_s):
        self.library, self.period_s = ctypes.CDLL(str(library)), period_s
        sizes = (ctypes.c_int * 3)()
        self.library.flown_sizes(sizes)
        self.measured, self.inputs, self.states = sizes
        self.y = (ctypes.c_float * max(1, self.measured))()
        self.u = (ctypes.c_float * max(1, self.inputs))()
        self.x_hat = (ctypes.c_float * self.states)()
        self.library.flown_sample.argtypes = [ctypes.POINTER(ctypes.c_float)] * 2 + [ctypes.c_float, ctypes.c_int,
                                                                                    ctypes.POINTER(ctypes.c_float)]

    def start(self):
        self.library.flown_start()

    def sample(self, y, u, gated, dt_s=0.0):
        """The bits of flown.cpp; self.x_hat has the estimate."""
        self.y[:] = y
        if self.inputs:
            self.u[:] = u
        return self.library.flown_sample(self.y, self.u, dt_s, gated, self.x_hat)


class Flight:
    """Samples of one flight: truth and estimate (N x n), bits (N), steps (N) [s]."""

    def __init__(self, truth, estimate, bits, step_s):
        self.truth, self.estimate = np.asarray(truth), np.asarray(estimate)
        self.bits, self.step_s = np.asarray(bits), np.asarray(step_s)

    def errors(self):
        return self.estimate - self.truth

    def settled_rms(self, after_s):
        """Of each state, without the first seconds."""
        late = np.cumsum(self.step_s) > after_s
        return np.sqrt(np.nanmean(self.errors()[late] ** 2, axis=0))

    def worst(self, rms):
        return float(np.nanmax(np.sqrt(np.nanmean(self.errors() ** 2, axis=0)) / rms))

    def lost(self, rms, after_s=0.0):
        """Which samples end a second whose rms error is far, in one of the states."""
        time = np.cumsum(self.step_s)
        squares = np.cumsum(np.nan_to_num((self.errors() / rms) ** 2) * self.step_s[:, None], axis=0)
        begins = np.searchsorted(time, time - LASTING_S)
        mean = (squares - squares[begins]) / LASTING_S
        return (mean.max(axis=1) > FAR**2) & (time > after_s + LASTING_S)

    def alarmed(self):
        return (self.bits & LOST_BITS) != 0

    def told(self):
        """Within the last second, by these or because the monitor is not armed: a restart has a transient."""
        time = np.cumsum(self.step_s)
        count = np.cumsum(self.alarmed() | ((self.bits & ARMED_BIT) == 0))
        begins = np.searchsorted(time, time - LASTING_S)
        return (count - np.where(begins > 0, count[np.maximum(begins - 1, 0)], 0)) > 0


def run(command, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\nexit {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def trained(nlo, experiment, data, work):
    """The model with its monitor, trained once for these bytes of program and experiment."""
    key = hashlib.sha256(pathlib.Path(nlo).read_bytes() + experiment.read_bytes()).hexdigest()[:16]
    folder = work / f"{experiment.stem}-{key}"
    model = folder / "model.json"
    if not (folder / "monitored").exists():
        logs = ["--data", data] if data else []
        run([nlo, "train", experiment, *logs, "-o", folder, "--force", "-q"])
        monitor = run([nlo, "monitor", model, *logs, "--quick", "--accept-undetected", "--json"])
        (folder / "monitored").write_text(monitor)
    return model


def exported(nlo, source, model, folder):
    """The two libraries: {"c++": ..., "c99": ...}."""
    said = json.loads(model.read_text())
    sizes = [f"-DFLOWN_MEASURED={len(said['outputs'])}", f"-DFLOWN_INPUTS={len(said.get('inputs', []))}",
             f"-DFLOWN_STATES={len(said['states'])}"]
    here = source / "tests/flown"
    libraries = {}
    for target, compiler, files in (("cpp", ["g++", "-std=c++20", "-fno-gnu-unique", f"-I{source}/runtime/include"],
                                     ["flown.cpp"]),  # each library has constants of its own, whatever else is loaded
                                    ("c99", ["gcc", "-std=c99", "-ffp-contract=off"], ["flown.c"])):
        out = folder / target
        out.mkdir(parents=True, exist_ok=True)
        run([nlo, "export", model, "--target", target, "--name", "flown", "-o", out / "flown.h"])
        own = [here / name for name in files] + ([out / "flown.c"] if target == "c99" else [])
        library = out / "flown.so"
        run([*compiler, "-O2", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared", f"-I{out}", *sizes, *own, "-o", library])
        libraries["c++" if target == "cpp" else "c99"] = Exported(library, said["sample_period_s"])
    return libraries


# ---- logs

class Log:
    """A log as nlo reads it: outputs, inputs, steps and truth, sample by sample."""

    def __init__(self, nlo, model, file, work):
        table = work / "log.csv"
        run([nlo, "evaluate", model, "--data", file, "--estimates", table])
        with open(table, newline="") as opened:
            rows = list(csv.reader(opened))
        said = json.loads(model.read_text())
        ny, nu, nx = len(said["outputs"]), len(said.get("inputs", [])), len(said["states"])
        values = np.array([[float(cell) for cell in row] for row in rows[1:]])
        self.period_s = said["sample_period_s"]
        self.step_s, self.outputs = values[:, 1], values[:, 2:2 + ny]
        self.inputs, self.truth = values[:, 2 + ny:2 + ny + nu], values[:, -nx:]
        self.names = [output["name"] for output in said["outputs"]]

    def fly(self, observer, outputs=None, gated=True, restart_at=None, keep=None):
        """keep: the samples that arrive; each step spans those that do not."""
        outputs = self.outputs if outputs is None else outputs
        observer.start()
        estimates, bits, truth, steps, waited = [], [], [], [], 0.0
        for k in range(len(outputs)):
            step = self.step_s[k] or (0.0 if k == 0 else self.period_s)
            waited += step
            if keep is not None and not keep[k]:
                continue
            if k == restart_at:
                observer.start()
            exact = self.step_s[k] == 0.0 and (keep is None or waited <= 1.001 * self.period_s)
            told = observer.sample(outputs[k], self.inputs[k], gated, 0.0 if exact else waited)
            estimates.append(list(observer.x_hat))
            bits.append(told)
            truth.append(self.truth[k])
            steps.append(waited)
            waited = 0.0
        return Flight(truth, estimates, bits, steps)


def faults_of(outputs, first):
    """(name, outputs with that fault from sample `first` on) for each output."""
    spread = np.nanstd(outputs, axis=0)
    random = np.random.default_rng(1)
    for j in range(outputs.shape[1]):
        for fault in ("dead", "frozen", "zero", "biased", "spiking"):
            bad = outputs.copy()
            if fault == "dead":
                bad[first:, j] = math.nan
            elif fault == "frozen":
                bad[first:, j] = bad[first - 1, j]
            elif fault == "zero":
                bad[first:, j] = 0.0
            elif fault == "biased":
                bad[first:, j] += 0.5 * spread[j]
            else:
                hit = first + random.choice(len(bad) - first, max(1, (len(bad) - first) // 20), replace=False)
                bad[hit, j] += 5.0 * spread[j] * random.choice([-1.0, 1.0], len(hit))
            yield f"{fault} {j}", bad


def log_flights(log, observer, settle_s):
    """name, flight behind the gate, flight without it or None, is it nominal"""
    half = len(log.outputs) // 2
    gap = max(2, int(0.2 / log.period_s))
    lost = np.ones(len(log.outputs), bool)
    lost[half:half + gap] = False
    every_second = np.arange(len(log.outputs)) % 2 == 0
    for name, options in (("nominal", {}), ("restart", {"restart_at": half}), ("gap", {"keep": lost}),
                          ("half rate", {"keep": every_second})):
        yield name, log.fly(observer, **options), log.fly(observer, gated=False, **options), name == "nominal"
    first = min(half, int(settle_s / log.period_s) + len(log.outputs) // 6)
    for name, outputs in faults_of(log.outputs, first):
        yield name, log.fly(observer, outputs), None, False


# ---- closed loops

class Motor:
    """tests/flown/motor.toml: a DC motor, its encoder's angle measured, a speed loop on the estimates."""

    period_s = 0.001

    def __init__(self):
        r, l, k, j, b = 1.0, 0.002, 0.04, 1e-4, 1e-5
        a = np.array([[0, 1, 0, 0, 0], [0, -b / j, k / j, -1 / j, 0], [0, -k / l, -r / l, 0, 1 / l], [0] * 5, [0] * 5], float)
        step, term = np.eye(5), np.eye(5)
        for n in range(1, 20):
            term = term @ a * self.period_s / n
            step = step + term
        self.step = step.tolist()

    def fly(self, observer, seconds, reference, gated=True, x0=(0.0, 0.0, 0.0, 0.02), faulty=None, restart_s=None):
        observer.start()
        x, v, integral = list(x0) + [0.0], 0.0, 0.0
        truth, estimates, bits = [], [], []
        for n in range(int(seconds / self.period_s)):
            t = n * self.period_s
            y = round(x[0] / 0.00873) * 0.00873
            if faulty is not None:
                y = faulty(t, y)
            if restart_s is not None and n == int(restart_s / self.period_s):
                observer.start()
            told = observer.sample([y], [v], gated)
            omega, current, load = observer.x_hat
            truth.append(x[1:4])
            estimates.append((omega, current, load))
            bits.append(told)
            error = reference(t) - omega
            integral += error * self.period_s * 0.5
            wanted = 0.05 * error + integral + 0.04 * omega + load / 0.04
            v = min(12.0, max(-12.0, wanted))
            if v != wanted:
                integral -= error * self.period_s * 0.5
            x[4] = v
            x = [sum(row[i] * x[i] for i in range(5)) for row in self.step]
        return Flight(truth, estimates, bits, np.full(len(bits), self.period_s))

    def flights(self, observer, long_s):
        def square(t):
            return 120.0 if math.sin(2 * math.pi * 0.5 * t) > 0 else -120.0

        yield "nominal", self.fly(observer, 20, square), self.fly(observer, 20, square, gated=False), True
        yield "restart at speed", self.fly(observer, 6, square, restart_s=3.2), \
            self.fly(observer, 6, square, gated=False, restart_s=3.2), False
        yield f"{long_s / 60:.0f} minutes at 120 rad/s", self.fly(observer, long_s, lambda t: 120.0), None, True
        last = {}

        def frozen(t, y):
            if t < 3.3:
                last["y"] = y
            return last["y"]

        faults = {"dead": lambda t, y: y if t < 3.3 else math.nan, "frozen": frozen,
                  "zero": lambda t, y: y if t < 3.3 else 0.0, "biased": lambda t, y: y if t < 3.3 else y + 1.0,
                  "spiking": lambda t, y: y + 3.0 if t > 3.3 and int(t * 1000) % 20 == 0 else y}
        for name, faulty in faults.items():
            yield f"{name} 0", self.fly(observer, 8, square, faulty=faulty), None, False


def integrate(f, x, h):
    a = f(x)
    b = f([p + h / 2 * q for p, q in zip(x, a)])
    c = f([p + h / 2 * q for p, q in zip(x, b)])
    d = f([p + h * q for p, q in zip(x, c)])
    return [p + h / 6 * (q + 2 * r + 2 * s + t) for p, q, r, s, t in zip(x, a, b, c, d)]


class Plant:
    """A plant of one output with a law on its estimates."""

    def __init__(self, f, period_s, noise, law, x0, horizon_s):
        self.f, self.period_s, self.noise, self.law, self.x0, self.horizon_s = f, period_s, noise, law, x0, horizon_s

    def fly(self, observer, gated=True, faulty=None, restart=False, jump=None):
        observer.start()
        random = np.random.default_rng(3)
        x, u, truth, estimates, bits = list(self.x0), 0.0, [], [], []
        samples = int(self.horizon_s / self.period_s)
        for n in range(samples):
            if n == samples // 2 and jump is not None:
                x = list(jump)
            if n == samples // 2 and restart:
                observer.start()
            y = x[0] + self.noise * random.standard_normal()
            if faulty is not None and n >= samples // 2:
                y = faulty(n - samples // 2, y)
            told = observer.sample([y], [u], gated)
            truth.append(list(x))
            estimates.append(list(observer.x_hat))
            bits.append(told)
            u = self.law(observer.x_hat)
            x = integrate(lambda s: self.f(s, u), x, self.period_s)
            if not all(abs(value) < 1e6 for value in x):
                break
        return Flight(truth, estimates, bits, np.full(len(bits), self.period_s))

    def flights(self, observer, _):
        yield "nominal", self.fly(observer), self.fly(observer, gated=False), True
        yield "restart", self.fly(observer, restart=True), self.fly(observer, gated=False, restart=True), False
        if self.jump is not None:
            yield "jump", self.fly(observer, jump=self.jump), self.fly(observer, gated=False, jump=self.jump), False
        random = np.random.default_rng(4)
        held = {}

        def frozen(n, y):
            held.setdefault("y", y)
            return held["y"]

        faults = {"dead": lambda n, y: math.nan, "frozen": frozen, "zero": lambda n, y: 0.0,
                  "biased": lambda n, y: y + self.bias,
                  "spiking": lambda n, y: y + 10 * self.bias * random.choice([-1, 1]) if n % 20 == 0 else y}
        for name, faulty in faults.items():
            held.clear()
            yield f"{name} 0", self.fly(observer, faulty=faulty), None, False


def van_der_pol():
    plant = Plant(lambda x, u: [x[1], (1 - x[0] ** 2) * x[1] - x[0]], 0.02, 0.5, lambda x_hat: 0.0, (1.0, 0.0), 120.0)
    plant.jump, plant.bias = (-1.5, 2.0), 1.0
    return plant


def balance():
    plant = Plant(lambda x, u: [x[1], 19.62 * math.sin(x[0]) - 0.1 * x[1] + u], 0.01, 0.01,
                  lambda x: min(15.0, max(-15.0, -(40 * x[0] + 9 * x[1]))), (0.2, 0.0), 60.0)
    plant.jump, plant.bias = (0.15, -0.3), 0.05
    return plant


LOOPS = {"motor": ("tests/flown/motor.toml", Motor, 0.3), "van_der_pol": ("trainer/experiments/van_der_pol.toml", van_der_pol, 10.0),
         "balance": ("trainer/experiments/balance.toml", balance, 1.0)}
LOGS = {"qube": ("qube.toml", "qube", "example_csv_fin8.csv", 2.0),
        "double_pendulum": ("double_pendulum.toml", "double_pendulum", "trajectory_03.csv", 1.0)}


def share(part, whole):
    return float(np.sum(part)) / float(np.sum(whole)) if np.sum(whole) else math.nan


def judged(model, language, flights, settle_s):
    """Prints a row per flight; returns the promises that are broken."""
    broken, rms = [], None
    for name, flight, plain, is_nominal in flights:
        rms = flight.settled_rms(settle_s) if rms is None else rms
        # A start has a transient, in which the monitor is not armed: it is not false, and not lost.
        lost = flight.lost(rms, settle_s)
        late = np.cumsum(flight.step_s) > settle_s
        false, known = share(flight.alarmed() & ~lost & late, ~lost & late), share(flight.told() & lost, lost)
        cost = plain and flight.worst(rms) / plain.worst(rms)
        print(f"{model:16} {language:4} {name:24} {flight.worst(rms):9.3g} {float(np.sum(flight.step_s[lost])):8.1f} "
              f"{'' if math.isnan(known) else format(known, '.2f'):>6} {false:7.4f} {'' if cost is None else format(cost, '.3f'):>7}",
              flush=True)
        where = f"{model}, {language}, {name}"
        if cost is not None and cost > MOST_GATE_COST:
            broken.append(f"{where}: the gate costs {cost:.2f} times the error")
        if is_nominal and false > MOST_FALSE:
            broken.append(f"{where}: told to be lost for {false:.1%} of a nominal flight")
        if is_nominal and np.any(lost):
            broken.append(f"{where}: lost in nominal flight")
        if known < LEAST_TOLD and (model, name) not in KNOWN_SILENT:
            broken.append(f"{where}: lost, and told in {known:.0%} of that time only")
        if known >= LEAST_TOLD and (model, name) in KNOWN_SILENT:
            broken.append(f"{where}: is told now; take it from KNOWN_SILENT")
    return broken


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    nlo, source, work = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    wanted = sys.argv[4:] or [*LOOPS, *LOGS]
    work.mkdir(parents=True, exist_ok=True)
    print(f"{'model':16} {'in':4} {'flight':24} {'error':>9} {'lost [s]':>8} {'told':>6} {'false':>7} {'gate':>7}")
    broken, skipped = [], False
    for name in wanted:
        if name in LOOPS:
            file, plant, settle_s = LOOPS[name]
            model = trained(nlo, source / file, None, work)
            for language, observer in exported(nlo, source, model, model.parent).items():
                long_s = 1200.0 if language == "c99" else 60.0
                broken += judged(name, language, plant().flights(observer, long_s), settle_s)
        elif name in LOGS:
            file, folder, log, settle_s = LOGS[name]
            data = source.parent / "shared/data" / folder
            if not data.is_dir():
                print(f"{name}: its logs are not here; left out")
                skipped = True
                continue
            model = trained(nlo, source / "trainer/experiments" / file, data, work)
            flown = Log(nlo, model, data / log, model.parent)
            for language, observer in exported(nlo, source, model, model.parent).items():
                broken += judged(name, language, log_flights(flown, observer, settle_s), settle_s)
        else:
            sys.exit(f"{name}: choose from {', '.join([*LOOPS, *LOGS])}")
    for line in broken:
        print("BROKEN  ", line)
    sys.exit(1 if broken else 77 if skipped and len(wanted) == 1 else 0)


if __name__ == "__main__":
    main()
