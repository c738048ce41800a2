#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Coverage of what flies: which lines and branches of the runtime its tests reach, over all instantiations together.

usage: tests/coverage/coverage.py [--jobs N] [--keep]

  --jobs N  compilers beside each other (all cores)
  --keep    take the programs of the last run in build/coverage, if their sources are older

Compiles tests/runtime/*_test.cpp by clang++ without optimisation, each also for the kernels that it has, runs them, and
prints every line and every side of a branch that nothing reached. One that tests/coverage/unreached.md explains counts
as reached; the run ends with exit 1 when another one is left, or when an explanation is no longer needed.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
WORK = ROOT / "build/coverage"
RUNTIME = ROOT / "runtime/include/nlo"
EXPLAINED = ROOT / "tests/coverage/unreached.md"
KERNELS = {"sse2": [], "scalar": ["-DNLO_SCALAR_KERNELS"], "avx512": ["-march=x86-64-v4"]}
OF_KERNELS = ("activation", "gated_batch", "jvp", "kernels", "kkl_batch", "mlp", "tanh")
LEFT_OUT = ("dispatch", "constant_time")  # other programs' headers; valgrind's business
CODE, GAP = 0, 3  # kinds of regions: code that runs, and space between


def programs():
    """(name, source, flags) of every program to compile."""
    for source in sorted((ROOT / "tests/runtime").glob("*_test.cpp")):
        name = source.stem.removesuffix("_test")
        if name not in LEFT_OUT:
            for kernels in KERNELS if name in OF_KERNELS else ["sse2"]:
                yield f"{name}_{kernels}", source, KERNELS[kernels]


def run(command, **settings):
    done = subprocess.run(command, capture_output=True, text=True, **settings)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
    return done.stdout


def compile_and_run(name, source, flags, keep):
    program = WORK / name
    if not (keep and program.exists() and program.stat().st_mtime > source.stat().st_mtime):
        run(["clang++", "-std=c++20", "-O0", "-fprofile-instr-generate", "-fprofile-update=atomic",
             "-fcoverage-mapping", "-DNLO_FLOAT_STRIDE=65537",
             *flags, "-I", ROOT, "-I", ROOT / "runtime/include", "-isystem", "/usr/include/eigen3", source,
             ROOT / "tests/runtime/linear_oracles.cpp", "-o", program, "-lgmock", "-lgtest_main", "-lgtest", "-lpthread"])
    raw = WORK / f"{name}.profraw"
    run([program, "--gtest_brief=1"], env=os.environ | {"LLVM_PROFILE_FILE": str(raw)})
    print(f"   {name}", flush=True)
    return program


def counts(names):
    """Times that each region of code and each side of a branch was reached: {(file, line, column, ...): count}. Each
    program has a profile of its own: kernels have one name and another body on each instruction set."""
    regions, branches = {}, {}
    for name in names:
        profile = WORK / f"{name}.profdata"
        run(["llvm-profdata", "merge", "-o", profile, WORK / f"{name}.profraw"])
        text = run(["llvm-cov", "export", "--format=text", f"--instr-profile={profile}", WORK / name])
        for function in json.loads(text)["data"][0]["functions"]:
            for l1, c1, l2, c2, count, file, _, kind in function["regions"]:
                where = function["filenames"][file]
                if kind == CODE and where.startswith(str(RUNTIME)):
                    key = (where, l1, c1)  # what `if constexpr` discards ends elsewhere
                    regions[key] = regions.get(key, 0) + count
            for l1, c1, l2, c2, taken, passed, file, *_ in function["branches"]:
                where = function["filenames"][file]
                if where.startswith(str(RUNTIME)):
                    key = (where, l1, c1, l2, c2)
                    old = branches.get(key, (0, 0))
                    branches[key] = (old[0] + taken, old[1] + passed)
    return regions, branches


def unreached(regions, branches):
    """(header, line number, what) of everything that was not reached. What `constexpr` stands before, compilers run."""
    reached = {file for file, *_ in regions}
    for header in sorted(RUNTIME.rglob("*.*")):
        if str(header) not in reached and "{" in header.read_text():
            yield str(header), 1, "no test compiles code of it"
    for (file, line, column, *_), count in sorted(regions.items()):
        if count == 0:
            yield file, line, "never runs"
    for (file, line, c1, l2, c2), (taken, passed) in sorted(branches.items()):
        if (taken == 0) != (passed == 0):  # neither: its region is told already
            condition = pathlib.Path(file).read_text().splitlines()[line - 1][c1 - 1:c2 - 1] if line == l2 else "..."
            yield file, line, f"`{condition}` is never {'true' if taken == 0 else 'false'}"


def report(regions, branches):
    explained = EXPLAINED.read_text()
    lines = {}
    left, used = 0, set()
    for file, line, what in unreached(regions, branches):
        code = lines.setdefault(file, pathlib.Path(file).read_text().splitlines())[line - 1].strip()
        name = str(pathlib.Path(file).relative_to(RUNTIME))
        if "constexpr" in code:
            continue
        if f"`{code}`" in explained or f"`{name}`" in explained:
            used |= {code, name}
            continue
        left += 1
        print(f"{pathlib.Path(file).relative_to(ROOT)}:{line}: {what}\n    {code}")
    sides = [side for pair in branches.values() if any(pair) for side in pair]
    print(f"{sum(c > 0 for c in regions.values())} of {len(regions)} regions, {sum(s > 0 for s in sides)} of {len(sides)} "
          f"sides of branches; {left} of the others without an explanation")
    stale = [code for code in re.findall(r"`([^`]+)`", explained.split("\n## ", 1)[1]) if code not in used]
    for code in stale:
        print(f"{EXPLAINED.name} explains what is reached now, or gone: {code}")
    return 1 if left or stale else 0


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--keep", action="store_true")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    chosen = list(programs())
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(lambda p: compile_and_run(*p, options.keep), chosen))
    return report(*counts([name for name, *_ in chosen]))


if __name__ == "__main__":
    sys.exit(main())
