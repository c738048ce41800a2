#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Compares training_epoch's steps of random samples and of gated units with PyTorch on this machine, in one run.

  usage: bench/training_torch.py [BUILD_DIR]      (build/release; Debian: python3-torch, libopenblas0-pthread)

PyTorch does less work: it gets z and the readings, whereas nlo draws noise, filters and samples in each step. The gated
units of PyTorch are torch.nn.GRU. Its reset acts after a product and not before it, with as many multiply-adds. Both
compute in float with Adam. The fastest of several bursts counts.
"""
import re
import subprocess
import sys
import time
from pathlib import Path

try:
    import torch
except ImportError:
    sys.exit("training_torch.py: no PyTorch for " + sys.executable + "; apt-get install python3-torch libopenblas0-pthread")

WORK = ("1,000 steps of 4,096 samples", "1,000 steps of 32 gated units")


def network(inputs, widths, outputs):
    layers = []
    for width in widths:
        layers += [torch.nn.Linear(inputs, width), torch.nn.Tanh()]
        inputs = width
    return torch.nn.Sequential(*layers, torch.nn.Linear(inputs, outputs))


class Samples(torch.nn.Module):
    """T* of 3-50x4-2 on 4,096 samples of z."""

    def __init__(self):
        super().__init__()
        self.map = network(3, [50] * 4, 2)
        self.z, self.x = torch.randn(4096, 3), torch.randn(4096, 2)

    def forward(self):
        return self.map(self.z)


class Gated(torch.nn.Module):
    """32 gated units over 16 segments of 1,001 samples, and T* of 32-32-2 on all of them."""

    def __init__(self):
        super().__init__()
        self.units, self.map = torch.nn.GRU(1, 32), network(32, [32], 2)
        self.y, self.x = torch.randn(1001, 16, 1), torch.randn(1001, 16, 2)

    def forward(self):
        return self.map(self.units(self.y)[0])


def seconds_of_1000_steps(model, steps):
    adam = torch.optim.Adam(model.parameters(), lr=1e-3)
    fastest = float("inf")
    for _ in range(6):  # the first one warms up
        start = time.perf_counter()
        for _ in range(steps):
            adam.zero_grad()
            ((model() - model.x) ** 2).mean().backward()
            adam.step()
        fastest = min(fastest, (time.perf_counter() - start) / steps)
    return 1000.0 * fastest


def seconds_of_nlo(build):
    said = subprocess.run([build / "bench" / "training_epoch", "5"], check=True, capture_output=True, text=True).stdout
    times = {}
    for block in said.split("\n\n"):
        rows = re.findall(r"^ +([12]) +([0-9.]+)", block, re.MULTILINE)
        if rows:
            times[name] = {int(threads): float(seconds) for threads, seconds in rows}
        name = block.strip().split("\n")[0].split(":")[0]
    return times


def main():
    build = Path(sys.argv[1] if len(sys.argv) > 1 else "build/release")
    if not (build / "bench" / "training_epoch").exists():
        sys.exit(f"training_torch.py: no bench/training_epoch in {build}; cmake --build {build} --target training_epoch")
    ours = seconds_of_nlo(build)
    print(f"PyTorch {torch.__version__}\n{'':32} threads   nlo [s]   torch [s]   torch / nlo")
    for name, model, steps in zip(WORK, (Samples(), Gated()), (50, 3)):
        for threads, seconds in ours[name].items():
            torch.set_num_threads(threads)
            theirs = seconds_of_1000_steps(model, steps)
            print(f"{name:32} {threads:7} {seconds:9.3f} {theirs:11.3f} {theirs / seconds:13.2f}")


if __name__ == "__main__":
    main()
