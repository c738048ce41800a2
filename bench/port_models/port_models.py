#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Counts cycles of the runtime's kernels on cores that we do not have, by llvm-mca's models of their ports.

usage: bench/port_models/port_models.py [--cores NAME,...] [--check | --write] [--also FLAG] [--work DIR]

  (none)    prints the table
  --check   compares with counted.json; exits with 1 if a figure has changed by more than 5 % or misses its goal
  --write   writes counted.json, and the table of README.md
  --cores   counts only for these cores of cores.json
  --also    one more flag for the compiler; may be repeated
  --work    directory for the compiled files (default: a temporary one)

exit status: 0 done, 1 a figure has changed, 2 wrong usage or a missing Debian package, 77 --check did not compare, because
a package is missing or the compiler is not the one that made counted.json
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import aarch64
import machine_code
import pressure
import x86

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PACKAGES = {"llvm-mca-14": "llvm-14", "llvm-mca-19": "llvm-19", "g++": "g++", "aarch64-linux-gnu-g++": "g++-aarch64-linux-gnu"}
TOLERANCE = 0.05
BEGIN, END = "<!-- table -->\n", "<!-- end of table -->\n"


def fail(text, status=2):
    print(f"port_models.py: {text}", file=sys.stderr)
    sys.exit(status)


def said(command, **options):
    done = subprocess.run(command, capture_output=True, text=True, **options)
    if done.returncode or " error:" in done.stderr:
        raise machine_code.Unknown(f"{' '.join(map(str, command))}\n{done.stderr[:2000]}")
    return done.stdout


def compiled(name, core, also, work):
    """Returns the assembly of kernels.cpp for this core."""
    target = work / f"{name}.s"
    said([core["compiler"], "-std=c++20", "-O3", "-DNDEBUG", *core["flags"], *also, f"-I{ROOT}", f"-I{ROOT}/runtime/include",
          "-S", HERE / "kernels.cpp", "-o", target], env=os.environ | {"LC_ALL": "C"})
    return machine_code.instructions(target.read_text())


def count(core, assembly, kernel, path, waits):
    """Returns (cycles of one call, cycles of its busiest ports)."""
    arm = core["compiler"].startswith("aarch64")
    text = machine_code.trace(aarch64.AArch64() if arm else x86.X86(), assembly, kernel, waits)
    text = text if arm else x86.loads_apart(text)
    for wrong, right in core.get("instead", {}).items():  # loads for which LLVM also reserves a port of the products
        text = re.sub(wrong, right, text)
    path.write_text(text)
    out = said([core["mca"], f"-march={'aarch64' if arm else 'x86-64'}", f"-mcpu={core['of']}", "-iterations=1",
                "-instruction-info=0", path])
    cycles, least = int(re.search(r"Total Cycles: +(\d+)", out)[1]), pressure.least_cycles(out)
    if least > cycles:
        raise machine_code.Unknown(f"{kernel} takes {cycles} cycles, fewer than the {least} that its ports need by llvm-mca")
    return cycles, least


def row(core, kernel, cycles, ports):
    """Describes a kernel on a core: cycles per multiply-add, its limit and the share of it that is reached, and the share
    of the time that the products and the loads of the weights alone would take."""
    lanes = core["bytes"] // 4
    plants = 2 * lanes if kernel.get("batch") else 1
    count = kernel["multiply_adds"] * plants
    needed = {"products": count / (lanes * core["multiply_adds"])}
    if not kernel.get("batch"):  # a batch loads its weights once for all plants
        needed["loads"] = count / (lanes * core["loads"])
    least = max(needed.values())
    binding = max(least, ports)
    share = binding / cycles
    return {"cycles": cycles, "per_multiply_add": round(cycles / count, 4), "limit": round(binding / count, 4),
            "by": "ports" if ports > least else " and ".join(sorted(name for name, value in needed.items() if value == least)),
            "share": round(share, 3), "of_products": round(least / cycles, 3),
            "met": round(share, 2) >= kernel["gate"] if "gate" in kernel else None}


def rows_of(name, table, also, work):
    core = table["cores"][name]
    assembly = compiled(name, core, also, work)
    return {kernel: row(core, of, *count(core, assembly, kernel, work / f"{name}.{kernel}.s", not of.get("batch")))
            for kernel, of in table["kernels"].items()}


def markdown(table, counted):
    """Returns a row per core and a column per kernel: cycles per multiply-add, shares of the limit and of the products."""
    kernels = table["kernels"]
    lines = ["| core | " + " | ".join(kernel["says"] for kernel in kernels.values()) + " |", "|---" * (len(kernels) + 1) + "|"]
    for name, rows in counted.items():
        cells = []
        for kernel, said_of in rows.items():
            gate = kernels[kernel].get("gate")
            cells.append(f"{said_of['per_multiply_add']:.4f}: {said_of['share']:.2f}" +
                         ("" if gate is None or said_of["met"] else f" of {gate:.2f}") + f", {said_of['of_products']:.2f}")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def versions(cores):
    return {tool: said([tool, "-dumpfullversion"]).strip() for tool in sorted({core["compiler"] for core in cores})}


def differences(now, before):
    """Returns the figures that have changed by more than TOLERANCE, and the goals that are missed."""
    for name, rows in now.items():
        for kernel, new in rows.items():
            old = before.get(name, {}).get(kernel)
            if old is None:
                yield f"{name}: {kernel} is not in counted.json"
            elif abs(new["cycles"] / old["cycles"] - 1) > TOLERANCE:
                yield f"{name}: {kernel} takes {new['cycles']} cycles, counted.json has {old['cycles']}"
            elif old["met"] and not new["met"]:
                yield f"{name}: {kernel} reaches {new['share']} of its limit, but reached its goal before"


def arguments():
    parser = argparse.ArgumentParser(usage=__doc__.split("usage: ")[1].split("\n\n")[0], add_help=True)
    parser.add_argument("--cores")
    parser.add_argument("--also", action="append", default=[])
    parser.add_argument("--work", type=pathlib.Path)
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--check", action="store_true")
    what.add_argument("--write", action="store_true")
    return parser.parse_args()


def main():
    options = arguments()
    table = json.loads((HERE / "cores.json").read_text())
    names = options.cores.split(",") if options.cores else list(table["cores"])
    for name in names:
        if name not in table["cores"]:
            fail(f"cores.json has no core {name}; it has {', '.join(table['cores'])}")
    cores = [table["cores"][name] for name in names]
    lacking = sorted({tool for core in cores for tool in (core["compiler"], core["mca"]) if not shutil.which(tool)})
    if lacking:
        fail(f"{', '.join(lacking)} not found; apt-get install {' '.join(PACKAGES[tool] for tool in lacking)}",
             77 if options.check else 2)
    path = HERE / "counted.json"
    before = json.loads(path.read_text()) if path.exists() else {"compilers": {}, "cores": {}}
    used = versions(cores)
    if options.check and any(before["compilers"].get(tool) != version for tool, version in used.items()):
        fail(f"not compared: counted.json was counted with {before['compilers']}, here is {used}", 77)

    with tempfile.TemporaryDirectory() as temporary, concurrent.futures.ThreadPoolExecutor(2) as pool:
        work = options.work or pathlib.Path(temporary)
        work.mkdir(parents=True, exist_ok=True)
        try:
            counted = dict(zip(names, pool.map(lambda name: rows_of(name, table, options.also, work), names)))
        except machine_code.Unknown as error:
            fail(error)
    print(f"{'core':15} {'kernel':12} {'cycles':>7} {'per multiply-add':>17} {'limit':>7} {'by':18} {'share':>5} {'of products':>11}  gate")
    for name, rows in counted.items():
        for kernel, of in rows.items():
            gate = table["kernels"][kernel].get("gate")
            print(f"{name:15} {kernel:12} {of['cycles']:7} {of['per_multiply_add']:17.4f} {of['limit']:7.4f} {of['by']:18} "
                  f"{of['share']:5.2f} {of['of_products']:11.2f}  " + ("" if gate is None else f"{gate:.2f} {'met' if of['met'] else 'open'}"))
    if options.write:
        everything = before["cores"] | counted if options.cores else counted
        path.write_text(json.dumps({"compilers": before["compilers"] | used, "cores": everything}, indent=1) + "\n")
        page = (HERE / "README.md").read_text()
        head, rest = page.split(BEGIN)
        (HERE / "README.md").write_text(head + BEGIN + "\n" + markdown(table, everything) + "\n" + END + rest.split(END)[1])
    if options.check:
        changed = list(differences(counted, before["cores"]))
        for line in changed:
            print(line, file=sys.stderr)
        if changed:
            fail("if this change is intended, run bench/port_models/port_models.py --write", 1)


if __name__ == "__main__":
    main()
