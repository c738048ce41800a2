#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""
usage: examples/rigs/car.py CHECKOUT OUT

Writes logs of the radio-controlled car DART from a checkout of DART: one row for each message of the car's sensors, with
the columns of trainer/experiments/car.toml. The files are OUT/FOLDER__RECORDING.csv; examples/rigs/README.md has the names
that car.toml expects.

The recordings repeat the latest sensor message at each frame of the motion capture (100 Hz). A row is kept where the
message changes (10 Hz), at the time of that frame. The truth is computed from the poses alone: x, y and yaw on an even
grid, a Butterworth low-pass of order 4 at 5 Hz that runs forwards and backwards, and central differences, which are turned
into the body's frame.
"""
import cmath
import hashlib
import math
import sys

import logs

FRAME_S = 0.01  # period of the motion capture [s]
CUTOFF_HZ = 5.0
ORDER = 4
SENSORS = (("acc_x", "acc x (IMU)", 4), ("acc_y", "acc y (IMU)", 4), ("yaw_rate", "W (IMU)", 5),
           ("wheel_speed", "vel encoder", 4), ("throttle", "throttle", 4), ("steering", "steering", 5))
TIME, STAMP = "vicon time", "elapsed time sensors"
POSE = ("vicon x", "vicon y", "vicon yaw")
LEAST_ROWS = 2000  # least number of frames of the motion capture: 20 s


def butterworth():
    """Returns the sections (b0, b1, b2, a1, a2) of the low-pass by the bilinear transform."""
    warped = math.tan(math.pi * CUTOFF_HZ * FRAME_S)
    sections = []
    for k in range(ORDER // 2):
        pole = warped * cmath.exp(1j * math.pi * (2 * k + ORDER + 1) / (2 * ORDER))
        damping, square = -2.0 * pole.real, abs(pole) ** 2
        scale = 1.0 + damping + square
        gain = square / scale
        sections.append((gain, 2 * gain, gain, 2.0 * (square - 1.0) / scale, (1.0 - damping + square) / scale))
    return sections


def filtered(signal, sections):
    """Filters forwards, starting at rest at the first value."""
    for b0, b1, b2, a1, a2 in sections:
        first = signal[0]  # unit gain at rest
        s2 = (b2 - a2) * first
        s1 = (b1 - a1) * first + s2
        result = []
        for x in signal:
            y = b0 * x + s1
            s1 = b1 * x - a1 * y + s2
            s2 = b2 * x - a2 * y
            result.append(y)
        signal = result
    return signal


def zero_phase(signal):
    """Filters forwards and backwards. Both ends are continued by their mirror image through the end point."""
    pad = min(len(signal) - 1, 100)
    before = [2 * signal[0] - v for v in signal[pad:0:-1]]
    behind = [2 * signal[-1] - v for v in signal[-2:-pad - 2:-1]]
    sections = butterworth()
    forwards = filtered(before + list(signal) + behind, sections)
    return filtered(forwards[::-1], sections)[::-1][pad:pad + len(signal)]


def interpolated(at, times, values):
    """Interpolates linearly. `at` and `times` must increase."""
    result, k = [], 0
    for t in at:
        while k + 2 < len(times) and times[k + 1] < t:
            k += 1
        share = min(max((t - times[k]) / (times[k + 1] - times[k]), 0.0), 1.0)
        result.append(values[k] + share * (values[k + 1] - values[k]))
    return result


def unwrapped(angle):
    result = [angle[0]]
    for value in angle[1:]:
        result.append(result[-1] + math.remainder(value - result[-1], 2 * math.pi))
    return result


def derivative(signal):
    middle = [(after - before) / (2 * FRAME_S) for before, after in zip(signal, signal[2:])]
    return [(signal[1] - signal[0]) / FRAME_S, *middle, (signal[-1] - signal[-2]) / FRAME_S]


def truth(times, x, y, yaw):
    """Returns (grid, v_x, v_y, r): the speeds of the marker in the body's frame, and the yaw rate."""
    grid = [k * FRAME_S for k in range(int(times[-1] / FRAME_S) + 1)]
    x, y, yaw = (zero_phase(interpolated(grid, times, v)) for v in (x, y, unwrapped(yaw)))
    dx, dy = derivative(x), derivative(y)
    v_x = [math.cos(p) * a + math.sin(p) * b for p, a, b in zip(yaw, dx, dy)]
    v_y = [-math.sin(p) * a + math.cos(p) * b for p, a, b in zip(yaw, dx, dy)]
    return grid, v_x, v_y, derivative(yaw)


def converted(text, name):
    """Returns the columns of the log, or None if the recording is too short or its sensors are silent."""
    columns = logs.table(text, [TIME, STAMP, *POSE, *(h for _, h, _ in SENSORS)], name)
    times = [t - columns[TIME][0] for t in columns[TIME]]
    frames, last = [], -1.0
    for k, t in enumerate(times):
        if t - last > 1e-4:  # repeated frames
            frames.append(k)
            last = t
    if len(frames) < LEAST_ROWS:
        return None
    kept = {h: [values[k] for k in frames] for h, values in columns.items()}
    times = [times[k] for k in frames]
    messages = [k for k in range(len(frames)) if k == 0 or kept[STAMP][k] - kept[STAMP][k - 1] > 0.01]
    if len(messages) < 100:
        return None
    grid, *speeds = truth(times, *(kept[h] for h in POSE))
    at = [times[k] for k in messages]
    log = {"time": at}
    log.update({ours: [kept[theirs][k] for k in messages] for ours, theirs, _ in SENSORS})
    log.update({ours: interpolated(at, grid, values) for ours, values in zip(("v_x", "v_y", "r"), speeds)})
    return log


def main():
    checkout, out = logs.folders(sys.argv, __doc__)
    decimals = {"time": 4, "v_x": 5, "v_y": 5, "r": 5, **{ours: digits for ours, _, digits in SENSORS}}
    seen = set()  # some recordings are in several folders
    for file in sorted(checkout.glob("*/**/Data/**/*.csv")):
        text = file.read_text(errors="replace")
        heading = text.partition("\n")[0]
        digest = hashlib.sha256(text.encode()).digest()
        if digest in seen or not all(h in heading for h in (STAMP, *POSE, *(h for _, h, _ in SENSORS))):
            continue
        seen.add(digest)
        log = converted(text, file)
        if log is not None:
            folder = file.relative_to(checkout).as_posix().split("Data/")[1].split("/")[0]
            logs.write(out / f"{folder}__{file.stem.removeprefix('car_1_Datarecording_')}.csv", log, decimals)
    if not seen:
        logs.fail(f"{checkout} has no recording with motion capture below a folder Data")


if __name__ == "__main__":
    main()
