#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Flies fully trained observers with their monitors as a user does: exported to C++ and to C99, in closed loops and
on logs, from rest, restarted, over gaps, at another rate, with sensors that fail.

usage: tests/flown/fly.py NLO SOURCE_DIR WORK_DIR [--table PAGE] [MODEL...]

  NLO       the program
  WORK_DIR  trained models, kept until the program or an experiment changes, and exports
  MODEL     only these: motor van_der_pol balance tanks cart_and_pendulum qube double_pendulum car car_free battery
            (default: all; models whose logs are missing are left out)
  --table   writes the flights in C++ into PAGE, between <!-- flights --> and <!-- end of flights -->; rows of other
            models are kept

A table row per flight:
  error    rms error divided by that in nominal flight, of the state with the largest quotient
  lost     time [s] during which the rms error of the last second (at least 16 samples) exceeds five times the nominal
  told     share of this time with a status, in_domain() or alarm that reports it within the last second, or a monitor
           that is not armed
  otherwise
           share of the remaining time in which one of them reports a lost estimate
  gate     rms error with the gate divided by that without it
  first    first alarm, domain or status that reports it, after the fault or after the estimate has settled

The exit code is 1 if a flight breaks a promise of docs/monitor.md: the gate costs more than 5 % in nominal flight, after a
restart, a jump or a gap; nominal flight is reported as lost for more than 1 % of its time and is not in KNOWN_FALSE; or a
lost flight is reported in less than 93 % of its lost seconds and is not in KNOWN_SILENT. A fault lasts for 30 s, so an alarm
may come 2 s after the estimate is lost. Trainings on processors with other instructions differ in their last bits, and
such delays differ by some tenths of a second.
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

FAR = 5.0  # times the nominal rms
LASTING_S, LASTING_SAMPLES = 1.0, 16  # how long a large error must last: the longer of both
MOST_GATE_COST, MOST_FALSE, LEAST_TOLD = 1.05, 0.01, 0.93
LOST_BITS = 1 | 2 | 4  # status, domain, alarm: flown.cpp
ARMED_BIT, ALARM_SHIFT = 16, 5
ALARMS = ("", "innovation mean", "innovation variance", "innovation correlation", "latent distance", "missing",
          "disagreement", "reset")  # nlo::Alarm

# (model, flight): why no status, domain or alarm reports that the estimate is lost. docs/monitor.md lists them.
KNOWN_SILENT = {
    ("balance", "biased 0"): "the pendulum balances where the biased sensor reads 0: it looks like a constant torque",
    ("tanks", "biased 0"): "a level that reads 1 cm too much looks like another level and another leak",
    ("battery", "biased 0"): "a biased voltage is the voltage of another state of charge",
    ("battery", "frozen 0"): "the prediction does not know the current: it takes 870 s to move further than at rest",
    ("car", "frozen 3"): "in circles of one speed the wheel speed stays where it is",
    ("car", "zero 3"): "a wheel that reads 0 is a car at rest until the prediction has moved away",
    ("car", "biased 3"): "in circles of one speed a biased wheel speed looks like another speed",
    ("car_free", "frozen 3"): "training has an encoder that repeats readings; observer.may_fail is for such a sensor",
    ("car_free", "biased 3"): "a biased wheel speed looks like another speed",
}
# Nominal flights that are reported as lost although they are not.
KNOWN_FALSE = {
    ("car_free", "nominal"): "its yaw rate is 1.6 times as hard to predict as the limit from the training logs, which "
                             "are circles but for one",
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
        """Steps one sample and returns the bits of flown.cpp; self.x_hat holds the estimate."""
        self.y[:] = y
        if self.inputs:
            self.u[:] = u
        return self.library.flown_sample(self.y, self.u, dt_s, gated, self.x_hat)


class Flight:
    """Samples of one flight: truth and estimate (N x n), bits (N), steps (N) [s]; the first sample that is faulty."""

    def __init__(self, truth, estimate, bits, step_s, faulty_from=None):
        self.truth, self.estimate = np.asarray(truth), np.asarray(estimate)
        self.bits, self.step_s = np.asarray(bits), np.asarray(step_s)
        self.faulty_from = faulty_from
        # A second, but at least 16 samples, so that one reading of a slow plant does not count as lost.
        self.lasting_s = max(LASTING_S, LASTING_SAMPLES * float(np.median(self.step_s)))

    def errors(self):
        return self.estimate - self.truth

    def settled_rms(self, after_s):
        """RMS error of each state, without the first after_s seconds."""
        late = np.cumsum(self.step_s) > after_s
        return np.sqrt(np.nanmean(self.errors()[late] ** 2, axis=0))

    def worst(self, rms):
        return float(np.nanmax(np.sqrt(np.nanmean(self.errors() ** 2, axis=0)) / rms))

    def lost(self, rms, after_s=0.0):
        """Returns for each sample whether the estimate is lost: the rms error of the last second and that of its first half
        are large in one of the states. The first half excludes one reading that jumps."""
        time = np.cumsum(self.step_s)
        squares = np.cumsum(np.nan_to_num((self.errors() / rms) ** 2) * self.step_s[:, None], axis=0)
        begins, half = (np.searchsorted(time, time - length) for length in (self.lasting_s, self.lasting_s / 2))
        whole = (squares - squares[begins]) / self.lasting_s
        first = (squares[half] - squares[begins]) / (self.lasting_s / 2)
        return np.any((whole > FAR**2) & (first > FAR**2), axis=1) & (time > after_s + self.lasting_s)

    def alarmed(self):
        return (self.bits & LOST_BITS) != 0

    def reported(self):
        """Returns for each sample whether a lost estimate was reported within the last second, or the monitor is not armed
        (a restart has a transient)."""
        time = np.cumsum(self.step_s)
        count = np.cumsum(self.alarmed() | ((self.bits & ARMED_BIT) == 0))
        begins = np.searchsorted(time, time - self.lasting_s)
        return (count - np.where(begins > 0, count[np.maximum(begins - 1, 0)], 0)) > 0

    def first_report(self, settle_s):
        """Returns the first alarm, domain or status after the fault, or after settling: "missing after 0.02 s"."""
        time = np.cumsum(self.step_s)
        at = np.flatnonzero(self.alarmed() & (time > settle_s) & (np.arange(len(time)) >= (self.faulty_from or 0)))
        if len(at) == 0:
            return ""
        bits = int(self.bits[at[0]])
        why = ALARMS[bits >> ALARM_SHIFT] or ("domain" if bits & 2 else "status")
        if self.faulty_from is None:
            return f"{why} at {time[at[0]]:.3g} s"
        return f"{why} after {time[at[0]] - time[self.faulty_from]:.2g} s"


def run(command, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\nexit {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def trained(nlo, experiment, data, work):
    """Returns the model with its monitor; trains it only if the program or the experiment has changed."""
    key = hashlib.sha256(pathlib.Path(nlo).read_bytes() + experiment.read_bytes()).hexdigest()[:16]
    folder = work / f"{experiment.stem}-{key}"
    model = folder / "model.json"
    if not (folder / "monitored").exists():
        logs = ["--data", data] if data else []
        run([nlo, "train", experiment, *logs, "-o", folder, "--force", "-q"])
        monitor = run([nlo, "monitor", model, *logs, "--quick", "--accept-undetected", "--json"])
        (folder / "monitored").write_text(monitor)
    return model


def measured_of(model):
    """Returns the names of the outputs that are measured, not computed from others."""
    return [output["name"] for output in model["outputs"] if "expression" not in output]


def exported(nlo, source, model, folder):
    """Exports and compiles the two libraries: {"c++": ..., "c99": ...}."""
    said = json.loads(model.read_text())
    sizes = [f"-DFLOWN_MEASURED={len(measured_of(said))}", f"-DFLOWN_INPUTS={len(said.get('inputs', []))}",
             f"-DFLOWN_STATES={len(said['states'])}"]
    here = source / "tests/flown"
    libraries = {}
    for target, compiler, files in (("cpp", ["g++", "-std=c++20", "-fno-gnu-unique", f"-I{source}/runtime/include"],
                                     ["flown.cpp"]),  # each library has its own constants, whichever else is loaded
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
        self.step_s, self.outputs = values[:, 1], values[:, 2:2 + len(measured_of(said))]
        self.inputs, self.truth = values[:, 2 + ny:2 + ny + nu], values[:, -nx:]

    def fly(self, observer, outputs=None, gated=True, restart_at=None, keep=None, faulty_from=None):
        """Flies the log. keep: samples that arrive; a step spans the samples that do not."""
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
            answer = observer.sample(outputs[k], self.inputs[k], gated, 0.0 if exact else waited)
            estimates.append(list(observer.x_hat))
            bits.append(answer)
            truth.append(self.truth[k])
            steps.append(waited)
            waited = 0.0
        return Flight(truth, estimates, bits, steps, faulty_from)


def faults_of(outputs, first):
    """Yields, for each output, its faults as (name, outputs with that fault from sample `first` on)."""
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
    """Yields name, flight with the gate, flight without it or None, whether it is nominal."""
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
        yield name, log.fly(observer, outputs, faulty_from=first), None, False


# ---- closed loops

class Motor:
    """tests/flown/motor.toml: a DC motor, its encoder's angle measured, a speed loop on the estimates."""

    period_s = 0.001
    flown_wrap = 8192.0  # rad: the observer ignores multiples of it, as the comment of the generated header says

    def __init__(self):
        r, l, k, j, b = 1.0, 0.002, 0.04, 1e-4, 1e-5
        a = np.array([[0, 1, 0, 0, 0], [0, -b / j, k / j, -1 / j, 0], [0, -k / l, -r / l, 0, 1 / l], [0] * 5, [0] * 5], float)
        step, term = np.eye(5), np.eye(5)
        for n in range(1, 20):
            term = term @ a * self.period_s / n
            step = step + term
        self.step = step.tolist()

    def fly(self, observer, seconds, reference, gated=True, x0=(0.0, 0.0, 0.0, 0.02), faulty=None, restart_s=None,
            modulo=False):
        observer.start()
        x, v, integral = list(x0) + [0.0], 0.0, 0.0
        truth, estimates, bits = [], [], []
        for n in range(int(seconds / self.period_s)):
            t = n * self.period_s
            y = round(x[0] / 0.00873) * 0.00873
            if modulo:
                y = math.fmod(y, self.flown_wrap)
            if faulty is not None:
                y = faulty(t, y)
            if restart_s is not None and n == int(restart_s / self.period_s):
                observer.start()
            answer = observer.sample([y], [v], gated)
            omega, current, load = observer.x_hat
            truth.append(x[1:4])
            estimates.append((omega, current, load))
            bits.append(answer)
            error = reference(t) - omega
            integral += error * self.period_s * 0.5
            wanted = 0.05 * error + integral + 0.04 * omega + load / 0.04
            v = min(12.0, max(-12.0, wanted))
            if v != wanted:
                integral -= error * self.period_s * 0.5
            x[4] = v
            x = [sum(row[i] * x[i] for i in range(5)) for row in self.step]
        return Flight(truth, estimates, bits, np.full(len(bits), self.period_s),
                      None if faulty is None else int(3.3 / self.period_s) + 1)

    def flights(self, observer, long_s):
        def square(t):
            return 120.0 if math.sin(2 * math.pi * 0.5 * t) > 0 else -120.0

        yield "nominal", self.fly(observer, 20, square), self.fly(observer, 20, square, gated=False), True
        yield "restart at speed", self.fly(observer, 6, square, restart_s=3.2), \
            self.fly(observer, 6, square, gated=False, restart_s=3.2), False
        # After minutes the angle is given modulo flown_wrap, as docs/runtime.md says: at 65,536 rad float is as coarse as
        # the encoder, and its rounding would raise alarms.
        yield f"{long_s / 60:.0f} minutes at 120 rad/s", \
            self.fly(observer, long_s, lambda t: 120.0, modulo=long_s > 300.0), None, True
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
    """A plant controlled by its estimates. outputs: the measured states; law(x_hat, t): the input."""

    def __init__(self, f, period_s, noise, law, x0, horizon_s, *, jump, bias, outputs=(0,)):
        self.f, self.period_s, self.noise, self.law, self.x0, self.horizon_s = f, period_s, noise, law, x0, horizon_s
        self.jump, self.bias, self.outputs = jump, bias, outputs

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
            y = [x[i] + self.noise * random.standard_normal() for i in self.outputs]
            if faulty is not None and n >= samples // 2:
                y = faulty(n - samples // 2, y)
            answer = observer.sample(y, [u], gated)
            truth.append(list(x))
            estimates.append(list(observer.x_hat))
            bits.append(answer)
            u = self.law(observer.x_hat, n * self.period_s)
            x = integrate(lambda s: self.f(s, u), x, self.period_s)
            if not all(abs(value) < 1e6 for value in x):
                break
        return Flight(truth, estimates, bits, np.full(len(bits), self.period_s),
                      None if faulty is None else samples // 2)

    def flights(self, observer, _):
        yield "nominal", self.fly(observer), self.fly(observer, gated=False), True
        yield "restart", self.fly(observer, restart=True), self.fly(observer, gated=False, restart=True), False
        yield "jump", self.fly(observer, jump=self.jump), self.fly(observer, gated=False, jump=self.jump), False
        random = np.random.default_rng(4)
        held = {}

        def frozen(n, y):
            return held.setdefault("y", y)

        faults = {"dead": lambda n, y: math.nan, "frozen": frozen, "zero": lambda n, y: 0.0,
                  "biased": lambda n, y: y + self.bias,
                  "spiking": lambda n, y: y + 10 * self.bias * random.choice([-1, 1]) if n % 20 == 0 else y}
        for j in range(len(self.outputs)):
            for name, faulty in faults.items():
                held.clear()
                yield f"{name} {j}", self.fly(observer, faulty=lambda n, y: [
                    faulty(n, value) if i == j else value for i, value in enumerate(y)]), None, False


def van_der_pol():
    return Plant(lambda x, u: [x[1], (1 - x[0] ** 2) * x[1] - x[0]], 0.02, 0.5, lambda x_hat, t: 0.0, (1.0, 0.0), 120.0,
                 jump=(-1.5, 2.0), bias=1.0)


def balance():
    return Plant(lambda x, u: [x[1], 19.62 * math.sin(x[0]) - 0.1 * x[1] + u], 0.01, 0.01,
                 lambda x, t: min(15.0, max(-15.0, -(40 * x[0] + 9 * x[1]))), (0.2, 0.0), 60.0,
                 jump=(0.15, -0.3), bias=0.05)


def tanks():
    """tests/flown/tanks.toml, its lower level is controlled to 8 and 14 cm in turn."""

    def outflow(level):
        return 0.178 * math.sqrt(2 * 981 * max(level, 0.0))

    def pump(x_hat, t):
        reference = 8.0 if t % 600 < 300 else 14.0
        return min(4.0, max(1.0, (outflow(reference) + x_hat[2]) / 10.0 + 0.15 * (reference - x_hat[1])))

    return Plant(lambda x, u: [(10.0 * u - outflow(x[0]) - x[2]) / 15.5, (outflow(x[0]) - outflow(x[1])) / 15.5, 0.0],
                 1.0, 0.2, pump, (12.0, 8.0, 2.0), 3600.0, jump=(10.0, 20.0, 3.0), bias=1.0, outputs=(1,))


def cart_and_pendulum():
    """The cart is pushed to both sides in turn, against its estimated speed."""

    def f(x, u):
        sin, cos = math.sin(x[2]), math.cos(x[2])
        push = u - 2.0 * x[0] - 0.5 * x[1] + 0.15 * x[3] ** 2 * sin
        mass = 1.0 + 0.3 * sin**2
        return [x[1], (push + 0.3 * 9.81 * sin * cos) / mass, x[3],
                (-push * cos - 1.3 * 9.81 * sin) / (0.5 * mass) - 0.1 * x[3]]

    return Plant(f, 0.02, 0.05, lambda x, t: min(3.0, max(-3.0, (1.5 if t % 8 < 4 else -1.5) - x[1])),
                 (0.2, 0.0, 0.3, 0.0), 60.0, jump=(-0.3, 0.4, 0.8, 0.0), bias=0.2, outputs=(0, 2))


LOOPS = {"motor": ("tests/flown/motor.toml", Motor, 0.3),
         "van_der_pol": ("trainer/experiments/van_der_pol.toml", van_der_pol, 10.0),
         "balance": ("trainer/experiments/balance.toml", balance, 1.0),
         "tanks": ("tests/flown/tanks.toml", tanks, 100.0),
         "cart_and_pendulum": ("trainer/experiments/plants/cart_and_pendulum.toml", cart_and_pendulum, 5.0)}
LOGS = {"qube": ("qube.toml", "qube", "example_csv_fin8.csv", 2.0),
        "double_pendulum": ("double_pendulum.toml", "double_pendulum", "trajectory_03.csv", 1.0),
        "car": ("car.toml", "car", "rubber_17.csv", 5.0), "car_free": ("car.toml", "car", "free_02.csv", 5.0),
        "battery": ("battery.toml", "battery", "25degC_Mixed7.csv", 600.0)}


def share(part, whole):
    return float(np.sum(part)) / float(np.sum(whole)) if np.sum(whole) else math.nan


LINE = "{:18} {:4} {:24} {:>9} {:>8} {:>6} {:>9} {:>7}  {}"
HEADING = ["flight", "error", "lost [s]", "told", "otherwise", "gate", "first"]


def judged(model, language, flights, settle_s, rows):
    """Prints a row per flight and appends it to `rows`; returns the promises that are broken."""
    broken, rms = [], None
    for name, flight, plain, is_nominal in flights:
        rms = flight.settled_rms(settle_s) if rms is None else rms
        # After a start the monitor is not armed during the transient, which counts neither as false nor as lost.
        lost = flight.lost(rms, settle_s)
        late = np.cumsum(flight.step_s) > settle_s
        false, known = share(flight.alarmed() & ~lost & late, ~lost & late), share(flight.reported() & lost, lost)
        cost = plain and flight.worst(rms) / plain.worst(rms)
        cells = [name, f"{flight.worst(rms):.3g}", f"{float(np.sum(flight.step_s[lost])):.1f}",
                 "" if math.isnan(known) else f"{known:.0%}", f"{false:.1%}", "" if cost is None else f"{cost:.3f}",
                 flight.first_report(settle_s)]
        rows.append(cells)
        print(LINE.format(model, language, *cells), flush=True)
        where = f"{model}, {language}, {name}"
        if cost is not None and cost > MOST_GATE_COST:
            broken.append(f"{where}: the gate costs {cost:.2f} times the error")
        if is_nominal and false > MOST_FALSE and (model, name) not in KNOWN_FALSE:
            broken.append(f"{where}: reported as lost for {false:.1%} of a nominal flight")
        if is_nominal and np.any(lost):
            broken.append(f"{where}: lost in nominal flight")
        if known < LEAST_TOLD and (model, name) not in KNOWN_SILENT:
            broken.append(f"{where}: lost, and reported in {known:.0%} of that time only")
        if known >= LEAST_TOLD and (model, name) in KNOWN_SILENT:
            broken.append(f"{where}: is reported now; remove it from KNOWN_SILENT")
        if is_nominal and false <= MOST_FALSE and (model, name) in KNOWN_FALSE:
            broken.append(f"{where}: is no longer reported as lost; remove it from KNOWN_FALSE")
    return broken


BEGIN, END = "<!-- flights -->\n", "<!-- end of flights -->"


def write_table(page, flown):
    """Writes the table of the page, with new rows for the models of `flown` (name: rows)."""
    text = page.read_text()
    if BEGIN not in text or END not in text:
        sys.exit(f"{page}: has no {BEGIN.strip()} and {END}")
    before, rest = text.split(BEGIN, 1)
    table, after = rest.split(END, 1)
    kept = {name: [] for name in [*LOOPS, *LOGS]}
    for line in table.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if cells[0] in kept:
            kept[cells[0]].append(cells[1:])
    kept.update(flown)
    lines = [["model", *HEADING], ["---"] * (1 + len(HEADING))]
    lines += [[name, *row] for name, rows in kept.items() for row in rows]
    table = "".join("| " + " | ".join(cells) + " |\n" for cells in lines)
    page.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}")


def main():
    arguments, page = sys.argv[1:], None
    if "--table" in arguments:
        at = arguments.index("--table")
        page = pathlib.Path(arguments[at + 1]) if at + 1 < len(arguments) else sys.exit(__doc__)
        del arguments[at:at + 2]
    if len(arguments) < 3:
        sys.exit(__doc__)
    nlo, source, work = (pathlib.Path(argument).resolve() for argument in arguments[:3])
    wanted = arguments[3:] or [*LOOPS, *LOGS]
    for name in wanted:
        if name not in LOOPS and name not in LOGS:
            sys.exit(f"{name}: choose from {', '.join([*LOOPS, *LOGS])}")
    work.mkdir(parents=True, exist_ok=True)
    print(LINE.format("model", "in", *HEADING))
    broken, flown = [], {}
    for name in wanted:
        if name in LOOPS:
            file, plant, settle_s = LOOPS[name]
            model = trained(nlo, source / file, None, work)
        else:
            file, folder, log, settle_s = LOGS[name]
            data = source.parent / "shared/data" / folder
            if not data.is_dir():
                print(f"{name}: its logs are missing; left out")
                continue
            model = trained(nlo, source / "trainer/experiments" / file, data, work)
            recorded = Log(nlo, model, data / log, model.parent)
        for language, observer in exported(nlo, source, model, model.parent).items():
            long_s = 1200.0 if language == "c99" else 60.0
            flights = plant().flights(observer, long_s) if name in LOOPS else log_flights(recorded, observer, settle_s)
            rows = []
            broken += judged(name, language, flights, settle_s, rows)
            flown.setdefault(name, rows)
    if page is not None:
        write_table(page, flown)
    for line in broken:
        print("BROKEN  ", line)
    sys.exit(1 if broken else 0 if flown else 77)


if __name__ == "__main__":
    main()
