#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Proves bounds over all floats by Gappa: the rounding error of each rational tanh (in the order of the deterministic policy
and of exported C99), of the gate made from it, of an int16 input and of an angle minus its whole turns. The
constants are read from the runtime. The distance of the rational function from tanh is bounded here, with 60 digits:
its error e has e' = W / D^2 - e (R + tanh), R = N / D, W = N'D - ND' - D^2 + N^2, so e
stays small between points where it is known.
Negative arguments follow by symmetry. Controls: a slightly wrong coefficient, more turns than float32 can count.
  gappa.py SOURCE_DIR
"""
import decimal
import pathlib
import re
import shutil
import struct
import subprocess
import sys

# Largest proven |tanh_rational - tanh|, by the name in the runtime: its constant in trainer/prove. A proof adds up
# errors that do not occur together; tests over all floats give kTanhMaxError, kTanh5e6MaxError, kTanh5e5MaxError.
SAYS = {"kTanh": "kProvenTanh", "kTanh5e6": "kProvenTanh5e6", "kTanh5e5": "kProvenTanh5e5", "double": "kProvenTanhDouble"}
CERTIFICATE = (pathlib.Path(__file__).parents[2] / "trainer/prove/proven_activation.h").read_text()
PROVEN = {name: float(re.search(rf"\b{says} = ([0-9e.-]+);", CERTIFICATE)[1]) for name, says in SAYS.items()}
MOST_TURNS = 1e5  # check_turns() of codegen; 2^16 are accepted in flight

decimal.getcontext().prec = 60
D = decimal.Decimal


def rounded(scalar, number):
    return D(float(number) if scalar == "double" else struct.unpack("f", struct.pack("f", float(number)))[0])


def fits(header):
    """Returns {name: (limit, p, q)} from activation.h, as exact decimals of the rounded constants."""
    text = re.sub(r"\bc\(([^()]*)\)", r"\1", header.read_text())
    found = {}
    for terms in re.finditer(r"TanhFit<(\w+), (\d)>\{\s*([\d.]+),\s*\{([^}]*)\},\s*\{([^}]*)\}\}", text):
        scalar, degree, limit, p, q = terms.groups()
        name = "double" if scalar == "double" else {"2": "kTanh5e5", "3": "kTanh5e6", "4": "kTanh"}[degree]
        p, q = ([rounded(scalar, n) for n in c.split(",")] for c in (p, q))
        found[name] = (rounded(scalar, limit), p, q)
    assert set(found) == set(PROVEN), found
    return found


def proven(script):
    """Returns Gappa's bounds for each `in ?` of the script: {expression: largest absolute value}."""
    said = subprocess.run(["gappa"], input=script, capture_output=True, text=True)
    bounds = {}
    number = r"(-?\d+)(?:b(-?\d+))?(?: \{[^}]*\})?"  # 3b-1 {1.5, 2^(0.58)}
    for expression, *ends in re.findall(rf"^  (.+) in \[{number}, {number}\]$", said.stdout + said.stderr, re.M):
        bounds[expression] = max(abs(int(n)) * 2.0 ** int(power or 0) for n, power in (ends[:2], ends[2:]))
    if not bounds:
        raise SystemExit(f"FAILED  Gappa finds no bound:\n{script}\n{said.stdout}{said.stderr}")
    return bounds


def horner(c, s):
    text = c[-1]
    for name in reversed(c[:-1]):
        text = f"({text} * {s} + {name})"
    return text


def by_halves(c, s, powers):
    if len(c) == 1:
        return c[0]
    low = max(n for n in (1, 2, 4, 8) if n < len(c))
    return f"({by_halves(c[low:], s, powers)} * {powers[low]} + {by_halves(c[:low], s, powers)})"


def rounding(name, limit, p, q):
    """Returns the largest |rounded - exact| of x P / Q over [0, limit], by relative bounds with |exact| < 1.01, and how far
    from 1 its value is at the limit, beyond which it is constant."""
    double = name == "double"
    text = f"@rnd = float<ieee_{64 if double else 32}, ne>;\nx = rnd(x_);\ns rnd= x * x;\nS = x * x;\n"
    for letter, c in (("p", p), ("q", q)):
        text += "".join(f"{letter}{k} = rnd({value});\n" for k, value in enumerate(c))
    for s, prefix, of in (("s", "", "rnd="), ("S", "e", "=")):
        powers = {1: s}
        for n in (2, 4, 8) if double else ():
            text += f"{s}{n} {of} {powers[n // 2]} * {powers[n // 2]};\n"
            powers[n] = f"{s}{n}"
        for letter, c in (("p", p), ("q", q)):
            names = [f"{letter}{k}" for k in range(len(c))]
            text += f"{prefix}{letter} {of} {by_halves(names, s, powers) if double else horner(names, s)};\n"
    text += "n rnd= x * p;\ny rnd= n / q;\nE = x * ep / eq;\n"
    small = "0x1p-100" if double else "0x1p-60"
    worst = proven(text + f"{{ x in [0, {small}] -> y - E in ? }}")["y - E"]
    for low, high in (small, "2"), ("2", "4"), ("4", limit):
        worst = max(worst, 1.01 * proven(text + f"{{ x in [{low}, {high}] -> y -/ E in ? }}\n$ x in 4;\n")["y -/ E"])
    return worst, proven(text + f"{{ x in [{limit}, {limit}] -> y - 1 in ? }}")["y - 1"]


def tanh(x):
    e = (-2 * x).exp()
    return (1 - e) / (1 + e)


def of_fit(limit, p, q):
    """Largest |x P / Q - tanh| over [0, limit]."""
    def spread(c, odd):  # from a polynomial in x^2 to one in x
        out = [D(0)] * (2 * len(c) + odd)
        for k, value in enumerate(c):
            out[2 * k + odd] = value
        return out

    def times(a, b):
        out = [D(0)] * (len(a) + len(b) - 1)
        for i, u in enumerate(a):
            for j, v in enumerate(b):
                out[i + j] += u * v
        return out

    def slope(a):
        return [k * v for k, v in enumerate(a)][1:]

    def at(a, x):
        total = D(0)
        for value in reversed(a):
            total = total * x + value
        return total

    n, d = spread(p, 1), spread(q, 0)
    w = [sum(part) for part in zip(*(v + [D(0)] * (4 * len(p) + 4 - len(v)) for v in (
        times(slope(n), d), [-v for v in times(n, slope(d))], [-v for v in times(d, d)], times(n, n))))]
    end, step, worst, x = limit, D(1) / 64, D(0), D(0)
    while x < end:
        half = min(step, end - x) / 2
        middle = x + half
        here = w[:]  # becomes the coefficients of W around `middle`
        size, power = D(0), D(1)
        for k in range(len(here)):
            for i in range(len(here) - 2, k - 1, -1):
                here[i] += middle * here[i + 1]
            size, power = size + abs(here[k]) * power, power * half
        change = size / at(d, x) ** 2  # D grows with x
        known = abs(at(n, middle) / at(d, middle) - tanh(middle))
        worst = max(worst, (known + half * change) / (1 - D("2.1") * half))
        x += step
    return float(worst)


def gate(bits, error):
    """Returns the error of (1 + t) / 2 for a t with the error `error` from tanh."""
    return proven(f"@rnd = float<ieee_{bits}, ne>;\nt = rnd(t_);\nh rnd= t * 0.5;\ng rnd= h + 0.5;\n"
                  f"G = T * 0.5 + 0.5;\n{{ T in [-1, 1] /\\ |t - T| <= {error} -> g - G in ? }}")["g - G"]


def int16_input():
    """Returns the error of rounding a value in +-32767 to an integer, which stays in +-32767."""
    text = ("@rnd = float<ieee_32, ne>;\nq = rnd(q_);\nu rnd= q + 0.5;\ni = int<zr>(u);\n"
            "{ q in [0, 32767] -> i in ? /\\ i - q in ? }\ni - q -> (i - u) + (u - (q + 0.5)) + 0.5;\n")
    bounds = proven(text)
    return bounds["i"], bounds["i - q"]


def turn(bits, most_turns=MOST_TURNS):
    """Returns the largest |angle - turn * whole_turns(angle, turn)| in turns, for angles of up to most_turns + 1 turns and
    any turn, which a power of 2 scales into [1, 2)."""
    worst, slices = 0.0, 16
    for k in range(slices):
        low, high = 1 + k / slices, 1 + (k + 1) / slices
        text = (f"@rnd = float<ieee_{bits}, ne>;\nc = rnd(c_);\nd = rnd(d_);\nt rnd= d / c;\nu rnd= t + 0.5;\n"
                "k = int<zr>(u);\nm rnd= c * k;\nw rnd= d - m;\n"
                f"{{ c in [{low}, {high}] /\\ d in [0.25, {high * (most_turns + 1)}] /\\\n"
                f"  t in [0.5, {most_turns + 2}] -> w in ? }}\n"
                "d - m -> c * (d / c - k) - (m - c * k);\nd / c - k -> (d / c - t) + (t - k);\n"
                "t - k -> (t + 0.5 - u) + (u - k) - 0.5;\n")
        worst = max(worst, proven(text)["w"] / low)
    return worst


def continued(bits, most_turns=MOST_TURNS):
    """Returns the largest |y - turn * whole_turns(y - last, turn)| in turns, for a last value within 0.6 turns."""
    worst, slices = 0.0, 16
    for k in range(slices):
        low, high = 1 + k / slices, 1 + (k + 1) / slices
        text = (f"@rnd = float<ieee_{bits}, ne>;\nc = rnd(c_);\na = rnd(a_);\ny = rnd(y_);\nd rnd= y - a;\n"
                "t rnd= d / c;\nu rnd= t + 0.5;\nk = int<zr>(u);\nm rnd= c * k;\nw rnd= y - m;\n"
                f"{{ c in [{low}, {high}] /\\ a in [{-0.6 * high}, {0.6 * high}] /\\ y in [-0.5, {high * most_turns}] /\\\n"
                f"  d in [0.25, {high * (most_turns + 1)}] /\\ t in [0.5, {most_turns + 2}] -> w in ? }}\n"
                "y - m -> a + (c * (d / c - k) - (m - c * k)) - (d - (y - a));\nd / c - k -> (d / c - t) + (t - k);\n"
                "t - k -> (t + 0.5 - u) + (u - k) - 0.5;\n")
        worst = max(worst, proven(text)["w"] / low)
    return worst


def main():
    if not shutil.which("gappa"):
        print("SKIPPED: no gappa here")
        return 77
    source, failed, errors = pathlib.Path(sys.argv[1]), False, {}

    def holds(what, value, most):
        nonlocal failed
        failed |= not value <= most
        print(f"{'ok     ' if value <= most else 'FAILED '} {what}: {value:.3g}, at most {most:g}")

    for name, fit in fits(source / "runtime/include/nlo/kernels/activation.h").items():
        exact, (added, beyond) = of_fit(*fit), rounding(name, *fit)
        errors[name] = max(exact + added, beyond)
        holds(f"tanh_rational {name} ({exact:.2g} of the fit, {added:.2g} of rounding, {beyond:.2g} beyond its limit)",
              errors[name], PROVEN[name])
    holds("gate, float", gate(32, errors["kTanh"]), PROVEN["kTanh"] / 2 + 2**-24)
    holds("gate, double", gate(64, errors["double"]), PROVEN["double"] / 2 + 2**-53)
    largest, off = int16_input()
    holds("largest int16 input", largest, 32767)
    holds("int16 input, in its last place", off, 0.5 + 2**-9)
    for bits in 32, 64:
        # An angle within 0.6 turns moves to at most 1.3 turns and is then brought back to 0.6.
        holds(f"angle next to its last, {bits} bits", continued(bits), 1.3)
        holds(f"angle less its whole turns, {bits} bits", turn(bits), 0.6)
    limit, p, q = fits(source / "runtime/include/nlo/kernels/activation.h")["kTanh"]
    if of_fit(limit, [p[0], p[1] * D("1.00001"), *p[2:]], q) < 10 * of_fit(limit, p, q):
        failed = True
        print("FAILED  a wrong coefficient was not detected")
    if turn(32, 100 * MOST_TURNS) <= 0.6:
        failed = True
        print("FAILED  turns that float32 cannot count were not detected")
    return failed


if __name__ == "__main__":
    sys.exit(main())
