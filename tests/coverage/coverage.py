#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Coverage of the code that flies: which lines and branches of the runtime its tests reach, over all instantiations, and
which lines of exported C99 hostile flights reach, over all pairs.

usage: tests/coverage/coverage.py [--jobs N] [--keep] [--only runtime|c99] [--export-model FILE]

  --jobs N             number of parallel compilers (all cores)
  --keep               reuse programs of the last run in build/coverage that are newer than their sources
  --only PART          only the runtime, or only C99
  --export-model FILE  the program that exports (build/release/tests/codegen/nlo_export_model)

Compiles tests/runtime/*_test.cpp by clang++ without optimisation, each also for the kernels that it has, and the C99 of
PAIRS behind tests/fuzz/hostile_flight.cpp, runs them, and prints every line and every side of a branch that nothing
reached. A line that tests/coverage/unreached.md explains counts as reached; the exit code is 1 if another line is
left, or when an explanation is no longer needed.
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
FLEET = WORK / "fleet"
EXPORT_MODEL = ROOT / "build/release/tests/codegen/nlo_export_model"
EXPLAINED = ROOT / "tests/coverage/unreached.md"
KERNELS = {"sse2": [], "scalar": ["-DNLO_SCALAR_KERNELS"], "avx512": ["-march=x86-64-v4"]}
OF_KERNELS = ("activation", "gated_batch", "jvp", "kernels", "kkl_batch", "mlp", "tanh")
LEFT_OUT = ("dispatch", "constant_time")  # tested by other programs, and by valgrind
CODE = 0  # the kind of a region with executable code
NO_INT16 = ("tiny_silu", "carried", "prior", "driven_error", "commanded_pendulum")
# Variants of each structure in each scalar: plain, with inputs, with sensors that may fail, saturating.
PAIRS = [f"c99_{scalar}:{example}" for scalar in ("float", "double", "int16") for example in (
    "rig", "linear", "tiny_zero_order", "tiny_relu", "tiny_silu", "commanded", "failing", "failing_rig", "saturating",
    "saturating_rig", "gated", "commanded_gated", "failing_gated", "carried", "prior", "driven_error", "commanded_pendulum",
    "commanded_general", "watched_rig", "watched_computed")
         if scalar != "int16" or example not in NO_INT16]
STEPS_MILLIONS = 5  # millions of steps, summed over all pairs
INSTRUMENTED = ["-O0", "-fprofile-instr-generate", "-fprofile-update=atomic", "-fcoverage-mapping"]


def programs():
    """(name, source, flags) of every program to compile."""
    for source in sorted((ROOT / "tests/runtime").glob("*_test.cpp")):
        name = source.stem.removesuffix("_test")
        if name not in LEFT_OUT:
            for kernels in KERNELS if name in OF_KERNELS else ["sse2"]:
                yield f"{name}_{kernels}", source, KERNELS[kernels]


def is_measured(file):
    return file.startswith(str(RUNTIME)) or (file.startswith(str(FLEET)) and file.endswith(".c"))


def run(command, **settings):
    done = subprocess.run(command, capture_output=True, text=True, **settings)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
    return done.stdout


def run_for_profile(program, *arguments):
    run([program, *arguments], env=os.environ | {"LLVM_PROFILE_FILE": f"{program}.profraw"})
    print(f"   {program.name}", flush=True)


def compile_and_run(name, source, flags, keep):
    program = WORK / name
    if not (keep and program.exists() and program.stat().st_mtime > source.stat().st_mtime):
        run(["clang++", "-std=c++20", *INSTRUMENTED, "-DNLO_FLOAT_STRIDE=65537",
             *flags, "-I", ROOT, "-I", ROOT / "runtime/include", "-isystem", "/usr/include/eigen3", source,
             ROOT / "tests/runtime/linear_oracles.cpp", "-o", program, "-lgmock", "-lgtest_main", "-lgtest", "-lpthread"])
    run_for_profile(program, "--gtest_brief=1")


def fly_exports(export_model, pool):
    """Compiles the hostile flights of all PAIRS into one program, whose coverage is counted separately."""
    if not export_model.exists():
        sys.exit(f"{export_model} is missing: build nlo_export_model, or name it by --export-model")
    run([ROOT / "tests/fuzz/write_fleet.sh", export_model.resolve(), FLEET, *PAIRS])
    include = ["-I", ROOT, "-I", ROOT / "runtime/include", "-I", FLEET]
    drivers = [*FLEET.glob("*.cpp"), ROOT / "tests/fuzz/hostile_flight.cpp"]
    commands = [["clang++", "-std=c++20", "-O1", *include, source] for source in drivers]
    commands += [["clang", "-std=c99", *INSTRUMENTED, source] for source in FLEET.glob("*.c")]
    objects = [FLEET / f"{command[-1].name}.o" for command in commands]
    list(pool.map(lambda c, o: run([*c, "-c", "-o", o]), commands, objects))
    run(["clang++", "-fprofile-instr-generate", *objects, "-o", WORK / "c99"])
    run_for_profile(WORK / "c99", str(STEPS_MILLIONS))


def code_of(file, line, cache={}):
    """Returns a line of a measured file. In exports the name and the float suffix, which differ, are removed."""
    if file not in cache:
        cache[file] = pathlib.Path(file).read_text()
        if file.startswith(str(FLEET)):
            cache[file] = re.sub(r"\b(\d+\.\d+)f\b", r"\1", cache[file].replace(pathlib.Path(file).stem, "NAME"))
        cache[file] = [text.strip() for text in cache[file].splitlines()]
    return cache[file][line - 1]


def counts(names):
    """Times that each region of code and each side of a branch was reached: {(file, line, column, ...): count}. Each
    program has a profile of its own: kernels have one name and another body on each instruction set. What is the same
    code of the same function in many exports is one place, that of the first of them."""
    regions, branches, first = {}, {}, {}
    for name in names:
        profile = WORK / f"{name}.profdata"
        run(["llvm-profdata", "merge", "-o", profile, WORK / f"{name}.profraw"])
        text = run(["llvm-cov", "export", "--format=text", f"--instr-profile={profile}", WORK / name])
        for function in json.loads(text)["data"][0]["functions"]:
            alike = {}

            def place(kind, file, line, *columns):
                if not file.startswith(str(FLEET)):
                    return (file, line, *columns)
                body = (kind, function["name"].split(":")[-1].replace(pathlib.Path(file).stem, "NAME"), code_of(file, line))
                alike[body] = alike.get(body, 0) + 1
                return first.setdefault((*body, alike[body]), (file, line, *columns))

            for l1, c1, l2, c2, count, file, _, kind in function["regions"]:
                where = function["filenames"][file]
                if kind == CODE and is_measured(where):
                    key = place("region", where, l1, c1)  # a region that `if constexpr` discards ends at another place
                    regions[key] = regions.get(key, 0) + count
            for l1, c1, l2, c2, taken, passed, file, *_ in function["branches"]:
                where = function["filenames"][file]
                if is_measured(where):
                    key = place("branch", where, l1, c1, l2, c2)
                    old = branches.get(key, (0, 0))
                    branches[key] = (old[0] + taken, old[1] + passed)
    return regions, branches


def unreached(regions, branches, of_runtime):
    """(file, line number, what) of everything that was not reached. Lines with `constexpr` are left out, because compilers run them."""
    reached = {file for file, *_ in regions}
    for header in sorted(RUNTIME.rglob("*.*")):
        if of_runtime and str(header) not in reached and "{" in header.read_text():
            yield str(header), 1, "no test compiles code of it"
    for (file, line, column, *_), count in sorted(regions.items()):
        if count == 0:
            yield file, line, "never runs"
    for (file, line, c1, l2, c2), (taken, passed) in sorted(branches.items()):
        if (taken == 0) != (passed == 0):  # if neither side ran, its region is already listed
            condition = pathlib.Path(file).read_text().splitlines()[line - 1][c1 - 1:c2 - 1] if line == l2 else "..."
            yield file, line, f"`{condition}` is never {'true' if taken == 0 else 'false'}"


def report(regions, branches, only):
    explained = EXPLAINED.read_text()
    left, used = 0, set()
    for file, line, what in unreached(regions, branches, only != "c99"):
        code, path = code_of(file, line), pathlib.Path(file)
        name = path.relative_to(FLEET if path.is_relative_to(FLEET) else RUNTIME).as_posix()
        if "constexpr" in code:
            continue
        if f"`{code}`" in explained or f"`{name}`" in explained:
            used |= {code, name}
            continue
        left += 1
        print(f"{path.relative_to(ROOT)}:{line}: {what}\n    {code}")
    for part, folder in ("runtime", RUNTIME), ("c99", FLEET):
        seen = [count for (file, *_), count in regions.items() if file.startswith(str(folder))]
        sides = [side for (file, *_), pair in branches.items() if file.startswith(str(folder)) and any(pair)
                 for side in pair]
        if seen:
            print(f"{part}: {sum(c > 0 for c in seen)} of {len(seen)} regions, {sum(s > 0 for s in sides)} of {len(sides)} "
                  "sides of branches")
    print(f"{left} of the others without an explanation")
    stale = [code for code in re.findall(r"`([^`]+)`", explained.split("\n## ", 1)[1]) if code not in used]
    if only:
        stale = []  # explanations of the other part may still be needed
    for code in stale:
        print(f"{EXPLAINED.name} explains what is reached now, or gone: {code}")
    return 1 if left or stale else 0


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--only", choices=["runtime", "c99"])
    parser.add_argument("--export-model", type=pathlib.Path, default=EXPORT_MODEL)
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    names = []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        if options.only != "c99":
            chosen = list(programs())
            list(pool.map(lambda p: compile_and_run(*p, options.keep), chosen))
            names += [name for name, *_ in chosen]
        if options.only != "runtime":
            fly_exports(options.export_model, pool)
            names.append("c99")
    return report(*counts(names), options.only)


if __name__ == "__main__":
    sys.exit(main())
