#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Mutation check: changes one token of a source, builds the tests that cover it, and checks that one of them fails.

usage: tests/mutation/mutate.py [--count N] [--seed S] [--minutes M] [--only FOLDER...] [--here] [--list]

  --count N      mutants to try in all, including earlier runs (300)
  --seed S       seed of the random choice of mutants (1)
  --minutes M    stop after this time, when the running mutant is finished (60)
  --only FOLDER...  only mutants in these folders, or in files whose names begin so
  --here         change this tree and build in its build/release; only for a clone that nobody else uses
  --list         print the mutants that would be tried, without building

Works on a copy of the tree in build/mutation, unless --here is given. Verdicts go to build/mutation/journal.jsonl,
from which a stopped run continues. An `invalid` mutant did not compile and does not count, except if a static_assert of a test refused it.
Prints the share that was killed and every survivor that tests/mutation/survivors.md does not explain, and ends with
exit 1 when less than 85 % were killed. Headers whose tests are sources of their own take two seconds for each mutant:

  tests/mutation/mutate.py --count 999 --only runtime/include/nlo/{monitor,error_head,delay_line,sensor,saturation}
"""
import argparse
import json
import os
import pathlib
import random
import re
import resource
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
WORK = ROOT / "build/mutation"
TREE = WORK / "tree"
BUILD = WORK / "build"
JOURNAL = WORK / "journal.jsonl"
WANTED = 0.85
TEST_LIMIT_S = {"program": 120, "source": 20}  # processor time, because the machine may be busy; an endless loop counts as a killed mutant

# The programs that cover a folder, quickest first, or sources that are a program each. The longest match decides.
COVERED_BY = {
    "runtime/include/nlo": ["observer_structures_test", "latent_test", "kkl_observer_test", "kernels_default_test"],
    "runtime/include/nlo/monitor": ["tests/runtime/monitor_test.cpp", "tests/runtime/monitor_recursions_test.cpp",
                                    "tests/runtime/monitor_state_test.cpp", "tests/runtime/upset_test.cpp"],
    "runtime/include/nlo/delay_line": ["tests/runtime/delay_line_test.cpp"],
    "runtime/include/nlo/error_head": ["tests/runtime/error_head_test.cpp"],
    "runtime/include/nlo/saturation": ["tests/runtime/saturation_test.cpp"],
    "runtime/include/nlo/sensor_failures": ["tests/runtime/sensor_failures_test.cpp"],
    "runtime/include/nlo/kernels/int16": ["codegen_test"],
    "runtime/include/nlo/quantised_map": ["codegen_test"],
    "codegen": ["codegen_test"],
    "trainer/gradients/nn": ["nn_test", "sensitivity_test"],
    "trainer/gradients/sensitivity": ["sensitivity_test", "structures_test"],
    "trainer/learn/losses": ["losses_test", "training_test"],
    "trainer/learn/optim": ["optim_test"],
    "trainer/rollout": ["rollout_test", "structures_test", "training_test"],
    "trainer/structures": ["structures_test", "sensitivity_test", "training_test"],
    "trainer/learn/training/objective": ["training_test"],
}
# Not compiled by these programs (kernels of other instruction sets), or data (tables).
LEFT_OUT = re.compile(r"arm|neon|avx|mve|cortex|registry|CMake")

# Compilers' messages about a wrong constant in a test.
WRONG_CONSTANT = re.compile(r"static.assert\w* failed|constant expression|constant initializer")

TOKENS = {
    " < ": " <= ", " <= ": " < ", " > ": " >= ", " >= ": " > ", " == ": " != ", " != ": " == ",
    " + ": " - ", " - ": " + ", " * ": " / ", " / ": " * ", " += ": " -= ", " -= ": " += ",
    " && ": " || ", " || ": " && ", "true": "false", "false": "true", "std::max": "std::min", "std::min": "std::max",
}
TOKEN = re.compile("|".join(re.escape(t) if t[0] == " " else rf"\b{t}\b" for t in TOKENS) + r"|(?<![\w.'])\d+(?![\w.'])")


def places(file, text):
    """(line, column, original, mutant) of every token that can be changed: code only, no text, templates or includes."""
    for number, line in enumerate(text.splitlines()):
        code = re.sub(r'"(?:\\.|[^"\\])*"', lambda m: " " * len(m[0]), line.split("//")[0])
        if code.lstrip().startswith(("#", "*", "template", "static_assert", "using")):
            continue
        for match in TOKEN.finditer(code):
            if match[0] in (" < ", " > ") and re.search(r"template|requires", code):
                continue
            yield number, match.start(), match[0], TOKENS.get(match[0]) or str(int(match[0]) + 1)


def mutants(seed, only):
    all_places = []
    for folder in COVERED_BY:
        for file in sorted(ROOT.glob(folder + ("*" if "objective" in folder else "/**/*"))):
            name = file.relative_to(ROOT).as_posix()
            if file.suffix in (".h", ".cpp", ".inc") and not LEFT_OUT.search(name) and name.startswith(tuple(only)):
                all_places += [(name, *place) for place in places(name, file.read_text())]
    random.Random(seed).shuffle(all_places)
    return all_places


def programs_for(name):
    return COVERED_BY[max((folder for folder in COVERED_BY if name.startswith(folder)), key=len)]


def is_source(program):
    return program.endswith(".cpp")


def run(*command):
    return subprocess.run(command, capture_output=True, text=True)


def build(program):
    if not is_source(program):
        return run("ninja", "-C", BUILD, program)
    flags = ["clang++", "-std=c++20", "-O1", "-I", TREE, "-I", TREE / "runtime/include"]
    common = BUILD / "common.h"
    if not common.exists():  # precompiled once, so each mutant compiles in a second
        common.write_text("#include <gtest/gtest.h>\n#include <algorithm>\n#include <cmath>\n#include <random>\n")
        run(*flags, "-x", "c++-header", common, "-o", f"{common}.pch")
    return run(*flags, "-include-pch", f"{common}.pch", TREE / program, "-o", BUILD / pathlib.Path(program).stem,
               "-lgtest_main", "-lgtest", "-lpthread")


def passes(program):
    source = is_source(program)
    path = BUILD / pathlib.Path(program).stem if source else next((BUILD / "tests").glob(f"*/{program}"))
    most = TEST_LIMIT_S["source" if source else "program"]
    limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (most, most))
    return subprocess.run([path, "--gtest_brief=1", "--gtest_fail_fast"], capture_output=True,
                          preexec_fn=limit).returncode == 0


def copy_the_tree(configure):
    shutil.rmtree(TREE, ignore_errors=True)
    shutil.copytree(ROOT, TREE, ignore=shutil.ignore_patterns("build", "out", ".git"))
    if configure:
        subprocess.run(["cmake", "-G", "Ninja", "-S", TREE, "-B", BUILD, "-DCMAKE_BUILD_TYPE=Release", "-DNLO_TESTS=ON",
                        "-DNLO_BENCH=OFF", "-DNLO_EXAMPLES=OFF", "-DNLO_WARNINGS_AS_ERRORS=OFF"], check=True,
                       capture_output=True)


def prepare(programs):
    BUILD.mkdir(parents=True, exist_ok=True)
    if TREE != ROOT:
        copy_the_tree(not all(map(is_source, programs)))
    for program in programs:
        built = build(program)
        if built.returncode != 0:
            sys.exit(f"{program} does not build without a mutant:\n{built.stdout[-2000:]}{built.stderr[-2000:]}")
        if not passes(program):
            sys.exit(f"{program} fails without a mutant: fix it first")


def verdict_of(mutant):
    name, number, column, original, changed = mutant
    file = TREE / name
    text = file.read_text()
    lines = text.splitlines(keepends=True)
    line = lines[number]
    lines[number] = line[:column] + changed + line[column + len(original):]
    file.write_text("".join(lines))
    try:
        for program in programs_for(name):
            built = build(program)
            if built.returncode != 0:
                return "killed" if WRONG_CONSTANT.search(built.stdout + built.stderr) else "invalid"
            if not passes(program):
                return "killed"
        return "survived"
    finally:
        file.write_text(text)


def key(mutant):
    """Returns a mutant's name in the journal: the text of its line, because line numbers change."""
    name, number, column, original, changed = mutant
    line = (ROOT / name).read_text().splitlines()[number]
    return {"file": name, "line": number + 1, "original": line.strip(),
            "mutant": (line[:column] + changed + line[column + len(original):]).strip()}


def report(entries):
    killed = sum(e["verdict"] == "killed" for e in entries)
    survivors = [e for e in entries if e["verdict"] == "survived"]
    explained = (ROOT / "tests/mutation/survivors.md").read_text()
    for e in survivors:
        known = f"`{e['mutant']}`" in explained or f"- all of `{e['file']}`" in explained
        print(f"{'explained' if known else 'SURVIVED '} {e['file']}:{e['line']}\n    {e['original']}\n    {e['mutant']}")
    for file in sorted({e["file"] for e in entries}):
        verdicts = [e["verdict"] for e in entries if e["file"] == file and e["verdict"] != "invalid"]
        print(f"{verdicts.count('killed'):4} of {len(verdicts):4} killed in {file}")
    valid = killed + len(survivors)
    print(f"{killed} of {valid} killed ({100.0 * killed / max(1, valid):.1f} %), {len(entries) - valid} did not compile")
    return 0 if valid and killed >= WANTED * valid else 1


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--only", nargs="+", default=[""])
    parser.add_argument("--here", action="store_true")
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    chosen = mutants(options.seed, options.only)
    if options.list:
        for mutant in chosen[:options.count]:
            print(json.dumps(key(mutant)))
        return 0
    entries = [json.loads(line) for line in JOURNAL.read_text().splitlines()] if JOURNAL.exists() else []
    tried = {(e["file"], e["original"], e["mutant"]) for e in entries}
    if os.nice(0) == 0:  # a priority that the user has chosen is kept
        os.nice(15)
    if options.here:
        global TREE, BUILD
        TREE, BUILD = ROOT, ROOT / "build/release"
    prepare(sorted({program for name, *_ in chosen for program in programs_for(name)}))
    end = time.monotonic() + 60 * options.minutes
    for mutant in chosen:
        if time.monotonic() > end or sum(e["verdict"] != "invalid" for e in entries) >= options.count:
            break
        entry = key(mutant)
        if (entry["file"], entry["original"], entry["mutant"]) in tried:
            continue
        entries.append(entry | {"verdict": verdict_of(mutant)})
        with JOURNAL.open("a") as journal:
            journal.write(json.dumps(entries[-1]) + "\n")
    return report(entries)


if __name__ == "__main__":
    sys.exit(main())
